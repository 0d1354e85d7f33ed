//! The fleet: its robots, which of them change, when and how; and its recordings.

use crate::Outcome;
use crate::robots::{Robot, TYPES, Type, Weight};
use exid::chain::effect;
use exid::problem::solution::Control;
use exid::problem_file::ProblemFile;
use exid::robot::random::{between, generator};
use exid::simulate::{self, SimulatedRecording, write_csv};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::Path;

/// One robot in so many changes.
const ONE_IN: usize = 20;

/// A planted change.
#[derive(Debug, Clone)]
pub struct Change {
    pub kind: &'static str,
    /// Absent where it belongs to no joint.
    pub joint: Option<usize>,
    /// The first night with it, from 1.
    pub night: usize,
    pub size: f64,
}

/// A change of a parameter, in its unit.
pub struct Step {
    pub parameter: String,
    pub size: f64,
}

/// The kinds of changes as a report names them.
pub const KINDS: [&str; 5] = [
    "friction up",
    "efficiency down",
    "load left on",
    "encoder offset",
    "delay up",
];

/// A robot of the fleet.
pub struct Member {
    pub name: String,
    pub of: &'static Type,
    pub robot: Robot,
    pub change: Option<Change>,
    seed: u64,
}

/// How well a night is recorded.
struct Quality {
    periods: usize,
    /// Over that of the fleet.
    noise: f64,
}

/// All robots.
pub struct Fleet {
    pub members: Vec<Member>,
    pub nights: usize,
}

/// What a fleet is drawn by.
#[derive(Clone, Copy)]
pub struct Draw {
    pub robots: usize,
    pub nights: usize,
    pub seed: u64,
}

impl Change {
    fn draw(of: &Type, number: usize, nights: usize, rng: &mut ChaCha8Rng) -> Self {
        let kind = KINDS[number % KINDS.len()];
        let mut one_of = |suits: &dyn Fn(Weight) -> bool| {
            let joints = (0..of.joints.len()).filter(|j| suits(of.joints[*j].weight));
            let joints: Vec<usize> = joints.collect();
            joints[rng.random_range(0..joints.len())]
        };
        let any = one_of(&|_| true);
        // A gear that transmits next to nothing loses next to nothing.
        let bears = one_of(&|weight| weight != Weight::None);
        let shows = one_of(&|weight| weight == Weight::Shows);
        // Enough nights before it for a history, and two from it on.
        let night = rng.random_range(nights.div_ceil(4) + 1..nights);
        let (joint, range) = match kind {
            "friction up" => (Some(any), [0.2, 0.6]),
            "efficiency down" => (Some(bears), [0.03, 0.08]),
            "load left on" => (None, [0.2, 0.8]),
            "encoder offset" => (Some(shows), [0.01, 0.03]),
            _ => (Some(any), [0.002, 0.006]),
        };
        Self {
            kind,
            joint,
            night,
            size: between(rng, range[0], range[1]),
        }
    }

    /// The parameter that it changes, and by how much in a robot.
    pub fn step(&self, robot: &Robot) -> Step {
        let of_joint = |parameter: &str| {
            let number = self.joint.map_or(0, |j| j + 1);
            format!("j{number}.{parameter}")
        };
        let coulomb = self.joint.map_or(0.0, |j| robot.joints[j].coulomb);
        let (parameter, size) = match self.kind {
            "friction up" => (of_joint("coulomb_friction.Fc"), self.size * coulomb),
            "efficiency down" => (of_joint("transmission_efficiency.R"), self.size),
            "encoder offset" => (of_joint("encoder_offset.offset"), self.size),
            "delay up" => (of_joint("time_delay.delay"), self.size),
            _ => ("payload.mass".to_string(), self.size),
        };
        Step { parameter, size }
    }

    fn apply(&self, robot: &mut Robot) {
        let size = self.size;
        match (self.kind, self.joint) {
            ("friction up", Some(j)) => robot.joints[j].coulomb *= 1.0 + size,
            ("efficiency down", Some(j)) => robot.joints[j].efficiency -= size,
            ("encoder offset", Some(j)) => robot.joints[j].encoder += size,
            ("delay up", Some(j)) => robot.joints[j].delay += size,
            _ => robot.tool += size,
        }
    }
}

impl Fleet {
    pub fn draw(by: Draw) -> Self {
        let member = |number: usize| {
            // A generator's seed is hashed: neighbours have nothing in common.
            let seed = by.seed << 20 | number as u64;
            let mut rng = generator(seed);
            let of = &TYPES[number % TYPES.len()];
            let robot = Robot::draw(of, &mut rng);
            let changes = number % ONE_IN == ONE_IN / 2;
            Member {
                name: format!("r{number:04}"),
                of,
                robot,
                change: changes.then(|| Change::draw(of, number / ONE_IN, by.nights, &mut rng)),
                seed,
            }
        };
        Self {
            members: (0..by.robots).map(member).collect(),
            nights: by.nights,
        }
    }

    /// Writes robot files, problems, recordings, manifest and truth.
    pub fn write(&self, folder: &Path) -> Outcome<()> {
        fs::create_dir_all(folder.join("recordings"))?;
        for of in &TYPES {
            fs::write(folder.join(format!("{}.urdf", of.name)), of.urdf())?;
            fs::write(folder.join(format!("{}.toml", of.name)), of.problem())?;
            let random = format!(
                "{}[design]\nperiod = 5.0\n[simulate]\ntrajectory = \"random\"\nperiods = 1\n",
                of.problem()
            );
            let text = random + &Robot::draw(of, &mut generator(0)).values(of);
            let made = simulated(&folder.join(format!("{}_motion.toml", of.name)), &text, 1)?;
            let mut trajectory = made.trajectories[0].clone();
            trajectory.name = format!("{}.trajectory.csv", of.name);
            save(folder, &trajectory)?;
        }
        self.members
            .par_iter()
            .try_for_each(|member| -> Outcome<()> {
                for night in 1..=self.nights {
                    member.record(folder, night)?;
                }
                Ok(())
            })?;
        fs::write(folder.join("truth.csv"), self.truth())?;
        fs::write(folder.join("manifest.csv"), self.manifest(self.nights))?;
        Ok(())
    }

    /// Whether a folder holds this fleet, whole.
    ///
    /// # Errors
    /// It holds another one.
    pub fn is_in(&self, folder: &Path) -> Outcome<bool> {
        match (
            fs::read_to_string(folder.join("truth.csv")),
            fs::exists(folder.join("manifest.csv"))?,
        ) {
            (Ok(truth), there) if truth == self.truth() => Ok(there),
            (Ok(_), _) => Err("the folder holds another fleet".into()),
            (Err(_), _) => Ok(false),
        }
    }

    /// What was planted.
    fn truth(&self) -> String {
        let mut truth = String::from("robot,type,kind,joint,night,size\n");
        for member in &self.members {
            if let Some(change) = &member.change {
                let joint = change
                    .joint
                    .map_or(String::new(), |j| member.of.joint_name(j));
                truth.push_str(&format!(
                    "{},{},{},{joint},{},{}\n",
                    member.name, member.of.name, change.kind, change.night, change.size
                ));
            }
        }
        truth
    }

    fn manifest(&self, nights: usize) -> String {
        let mut text = String::from("robot,type,recordings,problem,time\n");
        for night in 1..=nights {
            for member in &self.members {
                let (name, of) = (&member.name, member.of.name);
                text.push_str(&format!(
                    "{name},{of},recordings/{name}_{night:02}.csv,{of}.toml,{night}\n"
                ));
            }
        }
        text
    }

    /// Writes the manifest as it is after a night; gives its name.
    pub fn manifest_until(&self, folder: &Path, night: usize) -> Outcome<String> {
        let name = format!("until_{night:02}.csv");
        fs::write(folder.join(&name), self.manifest(night))?;
        Ok(name)
    }
}

impl Member {
    /// The robot as it is on a night.
    pub fn on(&self, night: usize) -> Robot {
        let mut rng = generator(self.seed ^ (night as u64) << 48);
        let mut robot = self.robot.tonight(&mut rng);
        if let Some(change) = self.change.as_ref().filter(|c| night >= c.night) {
            change.apply(&mut robot);
        }
        robot
    }

    fn record(&self, folder: &Path, night: usize) -> Outcome<()> {
        let name = format!("recordings/{}_{night:02}.csv", self.name);
        let good = Quality {
            periods: 4,
            noise: 1.0,
        };
        self.save(folder, (&name, night), good)
    }

    /// A short recording of the first night with much noise; gives its name.
    pub fn record_poorly(&self, folder: &Path) -> Outcome<String> {
        let name = format!("recordings/{}_poor.csv", self.name);
        let poor = Quality {
            periods: 2,
            noise: 5.0,
        };
        self.save(folder, (&name, 1), poor)?;
        Ok(name)
    }

    fn save(&self, folder: &Path, (name, night): (&str, usize), quality: Quality) -> Outcome<()> {
        let robot = self.on(night);
        let count = self.of.joints.len();
        let noise: Vec<f64> = self
            .of
            .joints
            .iter()
            .map(|joint| 0.1 * quality.noise * joint.friction)
            .collect();
        let text = format!(
            "{}[simulate]\ntrajectory = \"{}.trajectory.csv\"\nperiods = {}\nnoise = {noise:?}\nencoder_counts = {:?}\n{}",
            self.of.problem(),
            self.of.name,
            quality.periods,
            vec![65_536.0; count],
            robot.values(self.of)
        );
        let seed = self.seed ^ (night as u64) << 56;
        let mut made = simulated(&folder.join("simulated.toml"), &text, seed)?;
        let recording = &mut made.recordings[0];
        for (j, joint) in robot.joints.iter().enumerate() {
            let column = format!("q{}", j + 1);
            let column = recording.table.header.iter().position(|h| *h == column);
            let series = &mut recording.table.data[column.ok_or("no position")?];
            series.iter_mut().for_each(|q| *q -= joint.encoder);
        }
        recording.name = name.to_string();
        save(folder, recording)
    }
}

/// Recordings of a problem that is not written down.
fn simulated(path: &Path, text: &str, seed: u64) -> Outcome<simulate::Simulated> {
    let problem = ProblemFile::parse(path, text, &[], &effect::ids())?;
    Ok(simulate::run(&problem, seed, &Control::default())?)
}

fn save(folder: &Path, recording: &SimulatedRecording) -> Outcome<()> {
    let file = File::create(folder.join(&recording.name))?;
    Ok(write_csv(BufWriter::new(file), recording)?)
}
