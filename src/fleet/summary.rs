//! From sorted results to what is said of the fleet: types, robots to look at, failures.

use crate::chain::words::short;
use crate::fleet::change::{self, Common};
use crate::fleet::error::FleetError;
use crate::fleet::history::Night;
use crate::fleet::kind;
use crate::fleet::scratch::{Flag, Group, Scratch, Test, Tested, is_of_history};
use crate::fleet::settings::Counts;
use crate::outcome::fleet::{Fleet, HistoryPoint, LookAt, Reason, Shown, TypeFigures};
use crate::stats::false_discovery::Listing;

/// Items that were set aside that a result names.
const MOST_FAILURES: usize = 100;

/// Nights of a robot that its picture shows.
const SHOWN_NIGHTS: usize = 60;

/// Says what is to be said of all results, and leaves in the database what the table needs of it.
pub fn summarise(scratch: &Scratch, counts: Counts, rate: f64) -> Result<Fleet, FleetError> {
    scratch.sort()?;
    let groups = scratch.groups()?;
    let common: Vec<Common> = groups
        .into_iter()
        .map(|group| change::common(scratch, group))
        .collect::<Result<_, _>>()?;
    for common in &common {
        change::test(scratch, common)?;
    }
    scratch.sort_tests()?;
    let tested = scratch.tested()?;
    let of_robot = |robot: &Tested| (robot.tests as f64 * robot.least).min(1.0);
    let listing = Listing::of(tested.iter().map(of_robot).collect(), rate);
    let mut look_at = Vec::new();
    for robot in &tested {
        if listing.lists(robot.least, robot.tests) {
            look_at.push(listed(scratch, robot, &listing)?);
        }
    }
    // By what it would take to be listed, then by size.
    let order = |look: &LookAt| (look.evidence.p_value, -look.evidence.z.abs());
    look_at.sort_by(|a, b| {
        let (a, b) = (order(a), order(b));
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    for common in &common {
        change::pool(scratch, common)?;
    }
    let mut types = Vec::new();
    for name in scratch.types()? {
        let of_type = common.iter().filter(|common| common.group.kind == name);
        types.push(TypeFigures {
            robots: scratch.robots(&name)?,
            parameters: of_type.map(Common::figures).collect(),
            name,
        });
    }
    let robots = types.iter().map(|t| t.robots).sum();
    let mut fleet = Fleet {
        items: counts.items,
        robots,
        set_aside: counts.set_aside,
        rate,
        tests: tested.iter().map(|robot| robot.tests as u64).sum(),
        look_at,
        types,
        failures: scratch.failures(MOST_FAILURES)?,
        ..Fleet::default()
    };
    fleet.summary = in_words(&fleet);
    Ok(fleet)
}

/// A robot of the list, whose parameters the table is told of.
fn listed(scratch: &Scratch, robot: &Tested, listing: &Listing) -> Result<LookAt, FleetError> {
    // Up to rounding of what a robot is listed by.
    let most = robot
        .least
        .max(listing.rate * listing.listed as f64 / (listing.groups * robot.tests) as f64);
    let mut tests = scratch.tests(robot, most)?;
    for test in &mut tests {
        let rate = listing.rate_of(test.shown.p_value, robot.tests);
        test.shown.probability = 1.0 - rate.min(1.0);
    }
    // A change says more than that the robot is now unlike others, and comes first where both are sure.
    let is_of_history = |test: &Test| is_of_history(test.shown.reason);
    tests.sort_by(|a, b| {
        let by_reason = is_of_history(b).cmp(&is_of_history(a));
        by_reason.then(b.shown.z.abs().total_cmp(&a.shown.z.abs()))
    });
    for test in &tests {
        let since = test.shown.reason.words();
        scratch.add_flag(&Flag {
            kind: &robot.kind,
            robot: &robot.robot,
            shown: &test.shown,
            words: &format!("{}, {since}", test.shown.kind),
        })?;
    }
    let mut shown = tests.into_iter().map(|test| test.shown);
    let Some(evidence) = shown.next() else {
        return Err(FleetError::not_sorted(&"a listed robot has no test"));
    };
    let group = Group {
        kind: robot.kind.clone(),
        parameter: evidence.parameter.clone(),
        unit: evidence.unit.clone(),
    };
    let nights = scratch.nights(&group, &robot.robot)?;
    let kind = kind::of(&evidence.parameter, evidence.after - evidence.before);
    Ok(LookAt {
        robot: robot.robot.clone(),
        kind_of_robot: robot.kind.clone(),
        sentence: sentence(&evidence, &kind),
        kind: kind.words,
        joint: kind.joint,
        evidence,
        also: shown.collect(),
        history: history(&nights),
    })
}

fn history(nights: &[Night]) -> Vec<HistoryPoint> {
    let first = nights.len().saturating_sub(SHOWN_NIGHTS);
    let point = |night: &Night| HistoryPoint {
        time: night.time,
        value: night.value,
        std: night.std,
    };
    nights[first..].iter().map(point).collect()
}

/// What a person is told of a robot.
fn sentence(shown: &Shown, kind: &kind::Kind) -> String {
    let at = kind
        .joint
        .as_ref()
        .map_or(String::new(), |j| format!(" at {j}"));
    let [before, after] = [shown.before, shown.after].map(short);
    let unit = match shown.unit.as_str() {
        "" | "1" => String::new(),
        unit => format!(" {unit}"),
    };
    let (words, parameter) = (&kind.words, &shown.parameter);
    match shown.reason {
        Reason::Changed => format!("{words}{at}: {parameter} went from {before} to {after}{unit}"),
        Reason::Drifts => {
            format!("{words}{at}: {parameter} drifts, from about {before} to {after}{unit}")
        }
        Reason::UnlikeItsType => format!(
            "{words}{at} against its type: {parameter} is {after}{unit}, robots of the type have {before} ± {}",
            short(shown.before_std)
        ),
    }
}

fn in_words(fleet: &Fleet) -> String {
    let aside = match fleet.set_aside {
        0 => String::new(),
        1 => "; 1 item was set aside with its error".to_string(),
        many => format!("; {many} items were set aside with their errors"),
    };
    let look = match fleet.look_at.len() {
        0 => "no robot has changed or stands out".to_string(),
        1 => "one robot to look at".to_string(),
        many => format!("{many} robots to look at"),
    };
    let [items, robots] = [(fleet.items, "item"), (fleet.robots, "robot")].map(|(count, word)| {
        let plural = if count == 1 { "" } else { "s" };
        format!("{count} {word}{plural}")
    });
    format!(
        "{items} of {robots}{aside}; {look}, at a rate of false discoveries of {} %.",
        100.0 * fleet.rate
    )
}
