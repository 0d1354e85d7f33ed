//! Results sorted by robot, and by parameter: a temporary database of SQLite, which leaves to the disk what memory does not hold.
//!
//! Items come in the order in which they are done; every query has an order of its own, so that nothing depends on it.

use crate::fleet::error::FleetError;
use crate::fleet::history::Night;
use crate::fleet::item::{Found, Item, ItemOutcome, Value};
use crate::outcome::fleet::{Failure, Reason, Shown};
use crate::outcome::parameter::Source;
use crate::stats::random_effects::Pooled;
use rusqlite::{Connection, Row, params};

/// An empty name is a file that has none, and is gone with the process; pages beyond the cache lie in it.
const SETTINGS: &str = "
    PRAGMA cache_size = -16000; PRAGMA temp_store = FILE; PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF;
    CREATE TABLE item (id INTEGER PRIMARY KEY, type TEXT, robot TEXT, time REAL, code TEXT, message TEXT, findings TEXT);
    CREATE TABLE val (item INTEGER, place INTEGER, type TEXT, robot TEXT, time REAL, parameter TEXT, unit TEXT, value REAL,
                      std REAL, noise REAL, source TEXT, PRIMARY KEY (item, place)) WITHOUT ROWID;
    CREATE TABLE pooled (item INTEGER, place INTEGER, share REAL, value REAL, std REAL, PRIMARY KEY (item, place)) WITHOUT ROWID;
    CREATE TABLE test (type TEXT, robot TEXT, parameter TEXT, reason TEXT, p REAL, shown TEXT);
    CREATE TABLE flag (type TEXT, robot TEXT, parameter TEXT, since REAL, words TEXT, probability REAL,
                       PRIMARY KEY (type, robot, parameter)) WITHOUT ROWID;
    BEGIN;";

const INDICES: &str = "
    CREATE INDEX by_group ON val (type, parameter, robot, time, item);
    CREATE INDEX by_robot ON item (type, robot, time, id);";

/// The database while items come in.
pub struct Scratch {
    database: Connection,
}

/// A parameter of a type.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    pub kind: String,
    pub parameter: String,
    pub unit: String,
}

/// A robot with its tests.
#[derive(Debug, Clone, PartialEq)]
pub struct Tested {
    pub kind: String,
    pub robot: String,
    pub tests: usize,
    /// The least p-value of them.
    pub least: f64,
}

/// A test of a parameter of a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Test {
    pub kind: String,
    pub robot: String,
    pub shown: Shown,
}

/// A test of a group's parameter of one robot.
pub struct RobotTest {
    pub robot: String,
    pub shown: Shown,
}

/// What the value of a night leans on.
pub struct Leaning {
    pub night: Night,
    pub pooled: Pooled,
}

/// A parameter that is listed, as the table says it.
pub struct Flag<'a> {
    pub kind: &'a str,
    pub robot: &'a str,
    pub shown: &'a Shown,
    pub words: &'a str,
}

/// One row of the table.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TableRow {
    pub robot: String,
    pub kind: String,
    pub time: f64,
    pub parameter: Option<String>,
    pub unit: Option<String>,
    pub value: Option<f64>,
    pub std: Option<f64>,
    pub source: Option<String>,
    pub type_share: Option<f64>,
    pub pooled_value: Option<f64>,
    pub pooled_std: Option<f64>,
    pub finding: Option<String>,
    pub probability: Option<f64>,
    pub error: Option<String>,
}

impl Scratch {
    pub fn new() -> Result<Self, FleetError> {
        let database = Connection::open("")?;
        database.execute_batch(SETTINGS)?;
        Ok(Self { database })
    }

    /// Takes what an item came to.
    pub fn add(&self, item: &Item) -> Result<(), FleetError> {
        let entry = &item.entry;
        let nothing = Vec::new();
        let (values, findings, fault) = match &item.came_to {
            ItemOutcome::Done(done) => (&done.values, done.findings.as_slice(), None),
            ItemOutcome::SetAside(aside) => (&nothing, &[][..], Some(aside)),
        };
        let findings = serde_json::to_string(findings).map_err(|e| FleetError::not_sorted(&e))?;
        let mut insert = self
            .database
            .prepare("INSERT INTO item VALUES (?, ?, ?, ?, ?, ?, ?)")?;
        insert.execute(params![
            entry.position as i64,
            entry.kind,
            entry.robot,
            entry.time,
            fault.map(|f| &f.code),
            fault.map(|f| &f.message),
            findings
        ])?;
        let mut insert = self
            .database
            .prepare("INSERT INTO val VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)")?;
        for (place, value) in values.iter().enumerate() {
            let Value {
                parameter,
                unit,
                value,
                std,
                noise,
                source,
            } = value;
            insert.execute(params![
                entry.position as i64,
                place as i64,
                entry.kind,
                entry.robot,
                entry.time,
                parameter,
                unit,
                value,
                std,
                noise,
                source.as_str()
            ])?;
        }
        Ok(())
    }

    /// All items are there.
    pub fn sort(&self) -> Result<(), FleetError> {
        Ok(self.database.execute_batch(INDICES)?)
    }

    /// Every parameter of every type that recordings determine.
    pub fn groups(&self) -> Result<Vec<Group>, FleetError> {
        let sql = "SELECT type, parameter, min(unit) FROM val WHERE source = ? GROUP BY type, parameter ORDER BY type, parameter";
        let group = |row: &Row<'_>| {
            Ok(Group {
                kind: row.get(0)?,
                parameter: row.get(1)?,
                unit: row.get(2)?,
            })
        };
        let mut query = self.database.prepare(sql)?;
        let groups = query.query_map([Source::Data.as_str()], group)?;
        Ok(groups.collect::<Result<_, _>>()?)
    }

    /// Robots of a type.
    pub fn robots(&self, kind: &str) -> Result<u64, FleetError> {
        let sql = "SELECT count(DISTINCT robot) FROM item WHERE type = ?";
        let count: i64 = self.database.query_row(sql, [kind], |row| row.get(0))?;
        Ok(count as u64)
    }

    /// Types in the order of their names.
    pub fn types(&self) -> Result<Vec<String>, FleetError> {
        let mut query = self
            .database
            .prepare("SELECT DISTINCT type FROM item ORDER BY type")?;
        let types = query.query_map([], |row| row.get(0))?;
        Ok(types.collect::<Result<_, _>>()?)
    }

    /// The nights of each robot of a group, in the order of time.
    pub fn each_robot(
        &self,
        group: &Group,
        mut take: impl FnMut(&str, &[Night]) -> Result<(), FleetError>,
    ) -> Result<(), FleetError> {
        let sql = "SELECT robot, item, place, time, value, std, noise FROM val WHERE type = ? AND parameter = ? \
                   AND source = ? AND value IS NOT NULL AND std > 0 AND noise > 0 ORDER BY robot, time, item";
        let mut query = self.database.prepare(sql)?;
        let mut rows = query.query(params![group.kind, group.parameter, Source::Data.as_str()])?;
        let mut robot = String::new();
        let mut nights: Vec<Night> = Vec::new();
        while let Some(row) = rows.next()? {
            let name = row
                .get_ref(0)?
                .as_str()
                .map_err(|e| FleetError::not_sorted(&e))?;
            if name != robot {
                if !nights.is_empty() {
                    take(&robot, &nights)?;
                    nights.clear();
                }
                robot = name.to_string();
            }
            nights.push(Night {
                item: row.get::<_, i64>(1)? as u64,
                place: row.get::<_, i64>(2)? as u32,
                time: row.get(3)?,
                value: row.get(4)?,
                std: row.get(5)?,
                noise: row.get(6)?,
            });
        }
        if !nights.is_empty() {
            take(&robot, &nights)?;
        }
        Ok(())
    }

    /// The nights of one robot of a group.
    pub fn nights(&self, group: &Group, robot: &str) -> Result<Vec<Night>, FleetError> {
        let mut found = Vec::new();
        let sql = "SELECT item, place, time, value, std, noise FROM val WHERE type = ? AND parameter = ? AND robot = ? \
                   AND source = ? AND value IS NOT NULL AND std > 0 AND noise > 0 ORDER BY time, item";
        let mut query = self.database.prepare(sql)?;
        let mut rows = query.query(params![
            group.kind,
            group.parameter,
            robot,
            Source::Data.as_str()
        ])?;
        while let Some(row) = rows.next()? {
            found.push(Night {
                item: row.get::<_, i64>(0)? as u64,
                place: row.get::<_, i64>(1)? as u32,
                time: row.get(2)?,
                value: row.get(3)?,
                std: row.get(4)?,
                noise: row.get(5)?,
            });
        }
        Ok(found)
    }

    /// Keeps tests of robots of a group.
    pub fn add_tests(&self, group: &Group, tests: &[RobotTest]) -> Result<(), FleetError> {
        let mut insert = self
            .database
            .prepare("INSERT INTO test VALUES (?, ?, ?, ?, ?, ?)")?;
        for RobotTest { robot, shown } in tests {
            let text = serde_json::to_string(shown).map_err(|e| FleetError::not_sorted(&e))?;
            insert.execute(params![
                group.kind,
                robot,
                group.parameter,
                shown.reason.words(),
                shown.p_value,
                text
            ])?;
        }
        Ok(())
    }

    /// Every robot with how often it was tested.
    pub fn tested(&self) -> Result<Vec<Tested>, FleetError> {
        let sql = "SELECT type, robot, count(*), min(p) FROM test GROUP BY type, robot ORDER BY type, robot";
        let mut query = self.database.prepare(sql)?;
        let tested = query.query_map([], |row| {
            Ok(Tested {
                kind: row.get(0)?,
                robot: row.get(1)?,
                tests: row.get::<_, i64>(2)? as usize,
                least: row.get(3)?,
            })
        })?;
        Ok(tested.collect::<Result<_, _>>()?)
    }

    /// The tests of a robot with at most this p-value, the surest first.
    pub fn tests(&self, tested: &Tested, most: f64) -> Result<Vec<Test>, FleetError> {
        let sql = "SELECT shown FROM test WHERE type = ? AND robot = ? AND p <= ? ORDER BY p, parameter, reason";
        let mut query = self.database.prepare(sql)?;
        let mut rows = query.query(params![tested.kind, tested.robot, most])?;
        let mut tests = Vec::new();
        while let Some(row) = rows.next()? {
            let text: String = row.get(0)?;
            tests.push(Test {
                kind: tested.kind.clone(),
                robot: tested.robot.clone(),
                shown: serde_json::from_str(&text).map_err(|e| FleetError::not_sorted(&e))?,
            });
        }
        Ok(tests)
    }

    /// All tests are there.
    pub fn sort_tests(&self) -> Result<(), FleetError> {
        Ok(self
            .database
            .execute_batch("CREATE INDEX of_robot ON test (type, robot, p);")?)
    }

    /// Keeps that a parameter of a robot is listed; the first that is kept of a parameter stays.
    pub fn add_flag(&self, flag: &Flag<'_>) -> Result<(), FleetError> {
        let sql = "INSERT OR IGNORE INTO flag VALUES (?, ?, ?, ?, ?, ?)";
        self.database.prepare(sql)?.execute(params![
            flag.kind,
            flag.robot,
            flag.shown.parameter,
            flag.shown.since,
            flag.words,
            flag.shown.probability
        ])?;
        Ok(())
    }

    /// The first time from which a parameter of a robot is listed; minus infinity where it is at all times, `None` where it
    /// is not.
    pub fn flagged(&self, group: &Group, robot: &str) -> Result<Option<f64>, FleetError> {
        let sql = "SELECT since FROM flag WHERE type = ? AND robot = ? AND parameter = ?";
        let mut query = self.database.prepare(sql)?;
        let mut rows = query.query(params![group.kind, robot, group.parameter])?;
        match rows.next()? {
            None => Ok(None),
            Some(row) => Ok(Some(
                row.get::<_, Option<f64>>(0)?.unwrap_or(f64::NEG_INFINITY),
            )),
        }
    }

    /// Keeps what values lean on.
    pub fn add_pooled(&self, all: &[Leaning]) -> Result<(), FleetError> {
        let mut insert = self
            .database
            .prepare("INSERT INTO pooled VALUES (?, ?, ?, ?, ?)")?;
        for Leaning { night, pooled } in all {
            insert.execute(params![
                night.item as i64,
                night.place,
                pooled.share,
                pooled.mean.value,
                pooled.mean.variance.sqrt()
            ])?;
        }
        Ok(())
    }

    /// The first items that were set aside.
    pub fn failures(&self, most: usize) -> Result<Vec<Failure>, FleetError> {
        let sql = "SELECT robot, time, code, message FROM item WHERE code IS NOT NULL ORDER BY type, robot, time, id LIMIT ?";
        let mut query = self.database.prepare(sql)?;
        let failures = query.query_map([most as i64], |row| {
            Ok(Failure {
                robot: row.get(0)?,
                time: row.get(1)?,
                code: row.get(2)?,
                message: row.get(3)?,
            })
        })?;
        Ok(failures.collect::<Result<_, _>>()?)
    }

    /// Every row of the table in its order: by type, robot, time and position in the manifest.
    pub fn each_row(
        &self,
        mut take: impl FnMut(TableRow) -> Result<(), FleetError>,
    ) -> Result<(), FleetError> {
        let sql = "SELECT i.id, i.type, i.robot, i.time, i.code, i.message, i.findings, v.parameter, v.unit, v.value, v.std, \
                   v.source, p.share, p.value, p.std, f.since, f.words, f.probability \
                   FROM item i LEFT JOIN val v ON v.item = i.id \
                   LEFT JOIN pooled p ON p.item = v.item AND p.place = v.place \
                   LEFT JOIN flag f ON f.type = i.type AND f.robot = i.robot AND f.parameter = v.parameter \
                   ORDER BY i.type, i.robot, i.time, i.id, v.place";
        let mut query = self.database.prepare(sql)?;
        let mut rows = query.query([])?;
        let mut last = None;
        while let Some(row) = rows.next()? {
            let id: i64 = row.get(0)?;
            let of_item = TableRow {
                kind: row.get(1)?,
                robot: row.get(2)?,
                time: row.get(3)?,
                ..TableRow::default()
            };
            if last.replace(id) != Some(id) {
                let code: Option<String> = row.get(4)?;
                if let Some(code) = code {
                    let message: String = row.get(5)?;
                    take(TableRow {
                        error: Some(format!("{code}: {message}")),
                        ..of_item.clone()
                    })?;
                }
                let findings: String = row.get(6)?;
                let findings: Vec<Found> =
                    serde_json::from_str(&findings).map_err(|e| FleetError::not_sorted(&e))?;
                for found in findings {
                    take(TableRow {
                        finding: Some(found.sentence),
                        probability: found.probability,
                        ..of_item.clone()
                    })?;
                }
            }
            let parameter: Option<String> = row.get(7)?;
            if parameter.is_none() {
                continue;
            }
            let since: Option<f64> = row.get(15)?;
            let holds = since.is_none_or(|since| of_item.time >= since);
            let [words, probability] = [16, 17];
            take(TableRow {
                parameter,
                unit: row.get(8)?,
                value: row.get(9)?,
                std: row.get(10)?,
                source: row.get(11)?,
                type_share: row.get(12)?,
                pooled_value: row.get(13)?,
                pooled_std: row.get(14)?,
                finding: row.get::<_, Option<String>>(words)?.filter(|_| holds),
                probability: row.get::<_, Option<f64>>(probability)?.filter(|_| holds),
                ..of_item
            })?;
        }
        Ok(())
    }
}

/// Whether a reason is about a robot's own history.
pub fn is_of_history(reason: Reason) -> bool {
    reason != Reason::UnlikeItsType
}
