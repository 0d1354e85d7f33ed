//! Models and their base parameters: published counts and closed forms, and invariants of the reaction.

use crate::{LEADING, model, published_theta_d, shipped};
use exid::chain::base_parameters::BaseParameters;
use exid::chain::evaluate::{Evaluator, Segment};
use exid::chain::model::{Model, Signal};
use exid::chain::platform::{Platform, Rotor};
use exid::chain::rigid_bodies_only::rigid_bodies_only;
use exid::estimate::reactions::map;
use exid::robot::batch::Trajectory;
use exid::robot::inertia::{CentralInertia, Inertia};
use exid::robot::random::{generator, symmetric, tree};
use exid::robot::tree::{Joint, JointKind, Limits, Tree};
use nalgebra::{DMatrix, DVector, Isometry3, Matrix3, Rotation3, Vector3};
use std::fs;

const STATES: usize = 16;

/// Difference of the same quantity by two ways, relative to its largest entry: rounding.
const SAME: f64 = 1e-11;

fn structural(model: &Model) -> BaseParameters {
    let none = DMatrix::zeros(0, model.parameters().len());
    BaseParameters::structural(model, &[false], &none)
}

/// Bases of the joint-torque model and of the reaction model.
fn bases(model: &Model) -> (BaseParameters, BaseParameters) {
    let of = |signal| structural(&rigid_bodies_only(model, signal).unwrap());
    (of(Signal::Torque), of(Signal::BaseWrench))
}

/// The values that a basis gives a list of parameters.
fn values(base: &BaseParameters, parameters: &[f64]) -> Vec<f64> {
    let of = |others: &[(usize, f64)]| others.iter().map(|&(k, c)| c * parameters[k]).sum::<f64>();
    let all = base.base.iter();
    all.map(|b| parameters[b.parameter] + of(&b.others))
        .collect()
}

/// A link that turns about y, a height d above the base, as in the paper's Fig. 2.
const ONE_LINK: &str = r#"<robot name="one"><link name="base"/><link name="link"><inertial>
  <origin xyz="0 0.05 0.3"/><mass value="2.0"/>
  <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.015"/></inertial></link>
  <joint name="joint" type="continuous"><origin xyz="0 0 0.7"/><parent link="base"/><child link="link"/>
  <axis xyz="0 1 0"/></joint></robot>"#;

const ONE_LINK_PROBLEM: &str = "[robot]\nurdf = \"one.urdf\"\n\
    zero = [\"link.com_x\", \"link.inertia_xy\", \"link.inertia_xz\"]\n[recordings]\n\
    train = [\"none.csv\"]\nsignal = \"base_wrench\"\n";

#[test]
fn matches_published_parameters_of_one_link() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("one.urdf"), ONE_LINK).unwrap();
    let path = folder.path().join("problem.toml");
    fs::write(&path, ONE_LINK_PROBLEM).unwrap();
    let model = model(&path, &[]);
    let (joint, base) = bases(&model);
    let names = |base: &BaseParameters| -> Vec<String> {
        (0..base.base.len())
            .map(|k| base.expression(&model, k))
            .collect()
    };
    // The paper's θ_r = (m, mb_y, mb_z, K_yy, K_yz) and θ_d = (mb_z, K_yy), none combined with another.
    assert_eq!(
        names(&base),
        ["link.m", "link.mcy", "link.mcz", "link.Iyy", "link.Iyz"]
    );
    assert_eq!(names(&joint), ["link.mcz", "link.Iyy"]);
    let map = map(&joint, &base, model.parameters().len()).unwrap();
    let published = DMatrix::from_row_slice(2, 5, &[0., 0., 1., 0., 0., 0., 0., 0., 1., 0.]);
    assert!((map - published).amax() < 1e-12);
}

#[test]
fn matches_published_counts_of_parameters() {
    let full = model(&shipped(), &["robot.zero=[]"]);
    let (joint, base) = bases(&full);
    assert_eq!((joint.base.len(), base.base.len()), (15, 20));
    let zeros = model(&shipped(), &[]);
    let (joint, base) = bases(&zeros);
    assert_eq!((joint.base.len(), base.base.len()), (9, 11));
    // With the tare unknown, six of the combinations are the platform's.
    let tare = structural(&model(&shipped(), &["recordings.platform.tare=true"]));
    assert_eq!(tare.base.len(), 6 + 10);
}

#[test]
fn matches_published_closed_forms_and_the_map_between_the_models() {
    let model = model(&shipped(), &[]);
    let (joint, base) = bases(&model);
    let parameters = model.tree().parameters();
    let theta_d = values(&joint, &parameters);
    for (name, published) in LEADING.iter().zip(published_theta_d(model.tree())) {
        let leads = |b: &exid::chain::base_parameters::BaseParameter| {
            model.parameters()[b.parameter].name == *name
        };
        let at = joint
            .base
            .iter()
            .position(leads)
            .unwrap_or_else(|| panic!("{name}"));
        assert!(
            (theta_d[at] - published).abs() < 1e-9,
            "{name}: {} {published}",
            theta_d[at]
        );
    }
    let map = map(&joint, &base, model.parameters().len()).unwrap();
    let mapped = map * DVector::from_vec(values(&base, &parameters));
    assert!((mapped - DVector::from_vec(theta_d)).amax() < 1e-9);
}

#[test]
fn invariant_the_base_determines_the_joint_torques_of_any_tree() {
    let mut rng = generator(5);
    for n in [1, 3, 6] {
        let tree = tree(&mut rng, n);
        let model = rigid_bodies_only(&bare(tree), Signal::BaseWrench).unwrap();
        let (joint, base) = bases(&model);
        assert!(joint.base.len() <= base.base.len());
        assert!(map(&joint, &base, model.parameters().len()).is_some());
    }
}

/// A model of the bodies of a tree, all of them unknown.
fn bare(tree: Tree) -> Model {
    Model::new(exid::chain::model::ModelSettings::bodies(
        tree,
        Signal::BaseWrench,
    ))
    .unwrap()
}

type Motion = [Vec<Vec<f64>>; 3];

fn motion(joints: usize) -> Motion {
    let mut rng = generator(98);
    [1.5, 2.0, 8.0].map(|range| {
        let mut series = || (0..STATES).map(|_| symmetric(&mut rng, range)).collect();
        (0..joints).map(|_| series()).collect()
    })
}

fn wrench(model: &Model, [q, dq, ddq]: &Motion) -> DMatrix<f64> {
    let mut values = model.values();
    for (value, parameter) in values.iter_mut().zip(model.tree().parameters()) {
        *value = parameter;
    }
    let motors = Trajectory { q, dq, ddq };
    let mut evaluator = Evaluator::new(model, &values, &[]);
    let loaded = false;
    let block = evaluator.evaluate(Segment::states(motors, loaded), 0..STATES);
    DMatrix::from_fn(6, STATES, |c, s| block.value(c)[s])
}

#[test]
fn invariant_a_sensor_anywhere_reads_what_a_base_frame_there_would() {
    let mut rng = generator(6);
    let robot = tree(&mut rng, 5);
    let frame = Isometry3::new(Vector3::new(0.3, -0.2, 0.5), Vector3::new(0.4, -1.0, 0.7));
    let mut on_sensor = bare(robot.clone());
    on_sensor.stand_on(Platform {
        transfer: Platform::transfer_to(&frame),
        ..Platform::default()
    });
    // The same robot described from the sensor's frame.
    let mut joints = robot.joints().to_vec();
    for joint in joints.iter_mut().filter(|j| j.parent.is_none()) {
        let turn = frame.rotation.inverse().to_rotation_matrix();
        joint.translation = turn * (joint.translation - frame.translation.vector);
        joint.rotation = turn * joint.rotation;
    }
    let gravity = frame.rotation.inverse() * robot.gravity();
    let moved = bare(Tree::new("moved", "sensor", joints).with_gravity(gravity.into()));
    let motion = motion(5);
    let (found, expected) = (wrench(&on_sensor, &motion), wrench(&moved, &motion));
    assert!((&found - &expected).amax() <= SAME * expected.amax());
}

#[test]
fn invariant_a_spinning_rotor_is_a_body_that_turns() {
    const RATIO: f64 = 80.0;
    const INERTIA: f64 = 3e-3;
    let mut rng = generator(7);
    let robot = tree(&mut rng, 3);
    let place = Rotation3::new(Vector3::new(0.3, 0.8, -0.4));
    let disc = Inertia::from_central(&CentralInertia {
        mass: 0.4,
        centre: Vector3::zeros(),
        tensor: Matrix3::from_diagonal(&Vector3::new(0.5, 0.5, 1.0)) * INERTIA,
    });
    let at = Vector3::new(0.1, 0.05, -0.2);
    let mut joints = robot.joints().to_vec();
    let mut carrying = joints.clone();
    carrying[1].inertia = carrying[1].inertia.plus(&disc.seen_from(&place, &at));
    joints.push(Joint {
        name: "rotor".to_string(),
        link: "disc".to_string(),
        parent: Some(1),
        kind: JointKind::Revolute,
        axis: Vector3::z(),
        rotation: place,
        translation: at,
        limits: Limits::default(),
        inertia: disc,
    });
    let gravity: [f64; 3] = robot.gravity().into();
    let bodies = bare(Tree::new("bodies", "base", joints).with_gravity(gravity));
    let mut spinning = bare(Tree::new("spinning", "base", carrying).with_gravity(gravity));
    spinning.stand_on(Platform {
        rotors: vec![Rotor {
            joint: 2,
            carrier: Some(1),
            axis: place * Vector3::z(),
            momentum: INERTIA * RATIO,
        }],
        ..Platform::default()
    });
    let motion = motion(3);
    let with_rotor = motion.clone().map(|mut series| {
        series.push(series[2].iter().map(|x| RATIO * x).collect());
        series
    });
    let (found, expected) = (wrench(&spinning, &motion), wrench(&bodies, &with_rotor));
    let rest = wrench(&bare(spinning.tree().clone()), &motion);
    assert!(
        (&found - &rest).amax() > 0.01 * rest.amax(),
        "the rotor matters"
    );
    assert!((&found - &expected).amax() <= SAME * expected.amax());
}
