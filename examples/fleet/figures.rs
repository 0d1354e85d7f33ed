//! What the reports said against what was planted.

use crate::Outcome;
use crate::plant::{Change, Fleet, KINDS, Member};
use exid::fleet::task::{self, Settings};
use exid::outcome::fleet::{Fleet as Report, LookAt};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::RowAccessor;
use std::collections::{BTreeMap, HashSet};
use std::fs;
use std::path::Path;
use std::sync::Arc;

/// The report after a night.
pub struct Reported {
    pub night: usize,
    pub fleet: Report,
}

/// Nights from a change on within which it is to be found.
const IN_TIME: usize = 2;

/// Whether a report names kind and joint of a change.
fn is_right(member: &Member, change: &Change, look: &LookAt) -> bool {
    let joint = change.joint.map(|j| member.of.joint_name(j));
    look.kind == change.kind && look.joint == joint
}

pub fn print(fleet: &Fleet, reports: &[Reported]) {
    let changed = || {
        fleet
            .members
            .iter()
            .filter_map(|m| Some((m, m.change.as_ref()?)))
    };
    let named = |night: usize, member: &Member| {
        let report = reports.iter().find(|r| r.night == night)?;
        report
            .fleet
            .look_at
            .iter()
            .find(|look| look.robot == member.name)
    };
    println!(
        "\n| change | planted | found within {IN_TIME} nights | right joint and kind |\n|---|---|---|---|"
    );
    let (mut planted, mut found, mut right) = (0, 0, 0);
    for kind in KINDS {
        let of_kind: Vec<_> = changed()
            .filter(|(_, change)| change.kind == kind)
            .collect();
        let looks = of_kind.iter().filter_map(|(member, change)| {
            let nights = change.night..(change.night + IN_TIME).min(fleet.nights + 1);
            let look = nights.rev().find_map(|night| named(night, member))?;
            Some((member, change, look))
        });
        let looks: Vec<_> = looks.collect();
        let right_ones = looks
            .iter()
            .filter(|(member, change, look)| is_right(member, change, look))
            .count();
        for (member, change, look) in looks.iter().filter(|(m, c, l)| !is_right(m, c, l)) {
            eprintln!(
                "{}: {} at {:?} {:.3} taken for: {}",
                member.name, change.kind, change.joint, change.size, look.sentence
            );
        }
        println!(
            "| {kind} | {} | {} | {right_ones} |",
            of_kind.len(),
            looks.len()
        );
        planted += of_kind.len();
        found += looks.len();
        right += right_ones;
    }
    println!("| all | {planted} | {found} | {right} |");
    print_sizes(&sizes(fleet, reports));
    let is_false = |report: &Reported, look: &LookAt| {
        let member = fleet.members.iter().find(|m| m.name == look.robot);
        let change = member.and_then(|m| m.change.as_ref());
        change.is_none_or(|change| report.night < change.night)
    };
    let mut ever = HashSet::new();
    let mut ever_false = HashSet::new();
    let mut shares = 0.0;
    for report in reports {
        let wrong = report
            .fleet
            .look_at
            .iter()
            .filter(|look| is_false(report, look));
        let wrong: Vec<&str> = wrong.map(|look| look.robot.as_str()).collect();
        let listed = report.fleet.look_at.len();
        shares += wrong.len() as f64 / listed.max(1) as f64 / reports.len() as f64;
        ever.extend(report.fleet.look_at.iter().map(|look| look.robot.clone()));
        ever_false.extend(wrong.iter().map(|robot| robot.to_string()));
        if Some(report.night) == reports.last().map(|r| r.night) {
            println!(
                "\nlast report: {listed} robots, {} of them without a change",
                wrong.len()
            );
        }
    }
    println!(
        "mean over {} reports: {:.1} % without a change; over all of them {} robots listed, {} before or without a change",
        reports.len(),
        100.0 * shares,
        ever.len(),
        ever_false.len()
    );
}

/// Sizes of the planted changes in standard deviations of one night of the robot, as the last report has them.
fn sizes(fleet: &Fleet, reports: &[Reported]) -> Vec<f64> {
    let types = reports.last().map_or(&[][..], |last| &last.fleet.types);
    let size = |member: &Member| {
        let step = member.change.as_ref()?.step(&member.robot);
        let of_type = types.iter().find(|t| t.name == member.of.name)?;
        let mut parameters = of_type.parameters.iter();
        let figures = parameters.find(|p| p.name == step.parameter)?;
        Some(step.size / figures.between_nights.hypot(figures.of_a_fit))
    };
    let mut sizes: Vec<f64> = fleet.members.iter().filter_map(size).collect();
    sizes.sort_by(f64::total_cmp);
    sizes
}

fn print_sizes(sizes: &[f64]) {
    let (Some(least), Some(most)) = (sizes.first(), sizes.last()) else {
        return;
    };
    let middle = sizes[sizes.len() / 2];
    println!(
        "\nsizes of {} changes: {least:.1} to {most:.0} standard deviations of a night, median {middle:.0}",
        sizes.len()
    );
}

/// Nights of robots that are known already.
const KNOWN_NIGHTS: usize = 5;

/// Half of the robots are new, with one poor recording each: one period with five times the noise. Errors of what that
/// recording says alone and of what it says with the robots of the type, over all new robots and parameters, each in
/// units of the spread between robots.
pub fn first_nights(fleet: &Fleet, folder: &Path, settings: &Settings) -> Outcome<()> {
    let mut manifest = String::from("robot,type,recordings,problem,time\n");
    for (k, member) in fleet.members.iter().enumerate() {
        let (name, of) = (&member.name, member.of.name);
        if k % 2 == 1 {
            let recording = member.record_poorly(folder)?;
            manifest.push_str(&format!("{name},{of},{recording},{of}.toml,1\n"));
            continue;
        }
        for night in 1..=KNOWN_NIGHTS {
            manifest.push_str(&format!(
                "{name},{of},recordings/{name}_{night:02}.csv,{of}.toml,{night}\n"
            ));
        }
    }
    fs::write(folder.join("first.csv"), manifest)?;
    let ran = task::run(
        &folder.join("first.csv"),
        &folder.join("items"),
        settings,
        Arc::default(),
        |_| (),
    )?;
    let results = ran.results.ok_or("interrupted")?;
    let mut table = Vec::new();
    results.write_table(&mut table)?;
    let spread = |kind: &str, parameter: &str| {
        let of_type = results.fleet.types.iter().find(|t| t.name == kind)?;
        let figures = of_type.parameters.iter().find(|p| p.name == parameter)?;
        figures.between_robots.filter(|spread| *spread > 0.0)
    };
    let mut sums: BTreeMap<String, Errors> = BTreeMap::new();
    let path = folder.join("first.parquet");
    fs::write(&path, table)?;
    let file = fs::File::open(&path)?;
    for row in SerializedFileReader::new(file)?.get_row_iter(None)? {
        let row = row?;
        let [robot, kind] = [0, 1].map(|k| row.get_string(k).cloned().unwrap_or_default());
        let new = fleet
            .members
            .iter()
            .enumerate()
            .find(|(k, m)| k % 2 == 1 && m.name == robot);
        let (Some((_, member)), Ok(parameter)) = (new, row.get_string(3)) else {
            continue;
        };
        let (Some(truth), Some(spread)) = (member.robot.value(parameter), spread(&kind, parameter))
        else {
            continue;
        };
        let numbers: Result<Vec<f64>, _> =
            [5, 6, 9, 10].iter().map(|k| row.get_double(*k)).collect();
        let Ok([own, own_std, pooled, pooled_std]) =
            numbers.as_deref().map(|n| [n[0], n[1], n[2], n[3]])
        else {
            continue;
        };
        // Without the joint.
        let name = match parameter.split_once('.') {
            Some((_, of_joint)) if of_joint.contains('.') => of_joint.to_string(),
            _ => parameter.to_string(),
        };
        for key in [name, "all".to_string()] {
            sums.entry(key)
                .or_default()
                .add(spread, truth, [own, own_std], [pooled, pooled_std]);
        }
    }
    println!(
        "\n| parameter | error alone / spread | with the type | less by | 95 % interval alone covers | with the type |\n|---|---|---|---|---|---|"
    );
    for (name, errors) in &sums {
        println!("| {name} | {errors} |");
    }
    Ok(())
}

/// Errors over robots and parameters.
#[derive(Default)]
struct Errors {
    count: f64,
    own: f64,
    pooled: f64,
    own_covers: f64,
    pooled_covers: f64,
}

impl Errors {
    fn add(
        &mut self,
        spread: f64,
        truth: f64,
        [own, own_std]: [f64; 2],
        [pooled, pooled_std]: [f64; 2],
    ) {
        self.count += 1.0;
        self.own += ((own - truth) / spread).powi(2);
        self.pooled += ((pooled - truth) / spread).powi(2);
        self.own_covers += f64::from((own - truth).abs() < 1.96 * own_std);
        self.pooled_covers += f64::from((pooled - truth).abs() < 1.96 * pooled_std);
    }
}

impl std::fmt::Display for Errors {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [own, pooled] = [self.own, self.pooled].map(|sum| (sum / self.count).sqrt());
        let [own_covers, pooled_covers] =
            [self.own_covers, self.pooled_covers].map(|n| 100.0 * n / self.count);
        let less = 100.0 * (1.0 - pooled / own);
        write!(
            f,
            "{own:.3} | {pooled:.3} | {less:.0} % | {own_covers:.1} % | {pooled_covers:.1} %"
        )
    }
}
