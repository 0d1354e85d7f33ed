//! Figures of merit of a motion beside its criterion: expected deviations, coverage, paths of points; and the same of a reference
//! motion.

use nalgebra::Point3;

use crate::design::constraints::workspace::Rule;
use crate::design::context::DesignContext;
use crate::design::inputs::prepared::Prepared;
use crate::design::inputs::stated_motion::StatedMotion;
use crate::design::problem::Experiment;
use crate::design::results::coverage;
use crate::design::results::expected_deviations::ExpectedEstimate;
use crate::design::results::report;
use crate::design::trajectory::fourier_series::Basis;
use crate::design::trajectory::motion::{Motion, of_motors};
use crate::design::verify;
use crate::outcome::design::{CarriedJoint, Design, ExpectedDeviation, Reference, Way};
use crate::outcome::skeleton::{Skeleton, Wall};
use crate::robot::batch;
use crate::setup::skeleton;

/// Points of a way, and positions of a joint in a trajectory, about.
const POINTS: usize = 400;

impl DesignContext<'_> {
    /// Adds to a design what its motion is worth.
    pub fn judge(&self, motion: &Motion, design: &mut Design) {
        let Self {
            prepared,
            experiment,
            ..
        } = *self;
        let model = &prepared.model;
        let motors = of_motors(motion, experiment.observation.to_motors(), model.offset());
        let bodies = &prepared.values.as_slice()[..10 * model.tree().len()];
        let torques = batch::torques(model.tree(), bodies, motion.trajectory());
        let shown = coverage::of_motion(model, &motors, &torques, &prepared.limits);
        design.expected_std_dev = prepared.deviations(&motors);
        design.coverage = report::coverage(shown);
        design.carried = carried(experiment, motion);
        design.ways = ways(experiment, motion);
        design.skeleton = Some(prepared.skeleton(experiment));
        design.notes.splice(0..0, prepared.notes.iter().cloned());
    }
}

impl Prepared {
    /// The robot among the walls that its motion keeps away from.
    fn skeleton(&self, experiment: &Experiment<'_>) -> Skeleton {
        let walls = experiment
            .workspace
            .rules
            .iter()
            .filter_map(|rule| match rule {
                Rule::Halfspace { normal, offset, .. } => Some(Wall {
                    normal: (*normal).into(),
                    offset: *offset,
                }),
                _ => None,
            });
        Skeleton {
            walls: walls.collect(),
            ..skeleton::of(&self.robot)
        }
    }

    fn deviations(&self, motors: &Motion) -> Vec<ExpectedDeviation> {
        let recorded = ExpectedEstimate {
            model: &self.model,
            base: &self.base,
            prior: &self.prior,
            values: &self.values,
            loads: &self.loads,
            noise: &self.noise,
        };
        report::deviations(recorded.deviations(motors))
    }
}

/// Positions of the joints that loops move, trajectory by trajectory.
fn carried(experiment: &Experiment<'_>, motion: &Motion) -> Vec<CarriedJoint> {
    let joints = &experiment.joints;
    let samples = motion.len() / joints.trajectories;
    let count = samples.min(POINTS);
    let passive = joints.loops.iter().flat_map(|m| m.passive());
    passive
        .map(|&j| CarriedJoint {
            joint: experiment.workspace.tree.joints()[j].name.clone(),
            positions: motion.values[0][j]
                .chunks_exact(samples)
                .map(|own| (0..count).map(|k| own[k * samples / count]).collect())
                .collect(),
        })
        .collect()
}

/// The ways of the points that workspace limits name, or of the last link.
fn ways(experiment: &Experiment<'_>, motion: &Motion) -> Vec<Way> {
    let tree = experiment.workspace.tree;
    let mut points: Vec<(String, Option<usize>, Point3<f64>)> = Vec::new();
    for rule in &experiment.workspace.rules {
        if let Rule::Halfspace { place, .. } | Rule::Speed { place, .. } = rule
            && points.iter().all(|p| p.0 != place.name)
        {
            points.push((place.name.clone(), place.link, place.point));
        }
    }
    if let (true, Some(last)) = (points.is_empty(), tree.joints().last()) {
        points.push((last.link.clone(), Some(tree.len() - 1), Point3::origin()));
    }
    let stride = motion.len().div_ceil(POINTS).max(1);
    let mut ways: Vec<Way> = points
        .iter()
        .map(|(frame, ..)| Way {
            frame: frame.clone(),
            points: Vec::new(),
        })
        .collect();
    for k in (0..motion.len()).step_by(stride) {
        let q: Vec<f64> = motion.values[0].iter().map(|series| series[k]).collect();
        let links = tree.forward_kinematics(&q);
        for (way, (_, link, point)) in ways.iter_mut().zip(&points) {
            let p = link.map_or(*point, |link| links[link] * point);
            way.points.push([p.x, p.y, p.z]);
        }
    }
    ways
}

/// The motion to compare with, at as many samples per period as the design.
pub fn reference(context: &DesignContext<'_>, stated: &StatedMotion) -> Reference {
    let DesignContext {
        request,
        prepared,
        experiment,
    } = *context;
    let basis = Basis::new(stated.joints.series, experiment.basis.samples);
    let motion = Motion::of(&stated.joints, &basis, &stated.x);
    let mut memory = experiment.observation.workspace(motion.len());
    let information = experiment.observation.information(&motion, &mut memory);
    let matrix = experiment.target.matrix(&information);
    let motors = of_motors(
        &motion,
        experiment.observation.to_motors(),
        prepared.model.offset(),
    );
    let margins = verify::margins_of(experiment, &stated.joints, &stated.x);
    Reference {
        file: request
            .settings
            .reference
            .as_ref()
            .map_or_else(String::new, |r| r.written.clone()),
        criterion_value: match &experiment.rivals {
            Some(rivals) => rivals.value(&motion, &basis),
            None => matrix.map_or(f64::INFINITY, |m| experiment.target.criterion.value(&m)),
        },
        expected_std_dev: prepared.deviations(&motors),
        worst_margins: margins.iter().map(report::margin).collect(),
    }
}
