//! Broken robot files are refused with their code, place and remedy; odd but sound ones are read.

use crate::fault::Fault;
use crate::robot::assemble::MOST_JOINTS;
use crate::robot::error::RobotError;
use crate::robot::tree::Tree;
use crate::robot::{mdh, urdf};
use std::path::Path;

const JOINT: &str =
    r#"<joint name="j" type="revolute"><parent link="a"/><child link="b"/></joint>"#;

const INERTIAL: &str = r#"<inertial><mass value="1"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>"#;

fn read_urdf(text: &str) -> Result<Tree, RobotError> {
    urdf::parse(text, Path::new("arm.urdf"))
}

fn read_mdh(text: &str) -> Result<Tree, RobotError> {
    mdh::parse(text, Path::new("arm.toml"))
}

/// Links a (base) and b, and what else stands in the robot.
fn robot(content: &str) -> String {
    format!("<robot name=\"r\">\n<link name=\"a\"/>\n<link name=\"b\"/>\n{content}\n</robot>")
}

fn joint(attributes: &str, content: &str) -> String {
    robot(&format!(
        "<joint {attributes}><parent link=\"a\"/><child link=\"b\"/>{content}</joint>"
    ))
}

fn link(content: &str) -> String {
    robot(&format!("{JOINT}<link name=\"c\">{content}</link>"))
}

/// A broken URDF: the code, the line and the text.
type Broken = (&'static str, Option<usize>, String);

/// Elements that cannot be read.
fn broken_elements() -> Vec<Broken> {
    vec![
        ("urdf-not-xml", Some(2), "<robot>\n</rebot>".into()),
        (
            "urdf-not-xml",
            Some(1),
            "<!DOCTYPE robot []><robot/>".into(),
        ),
        ("urdf-not-robot", Some(1), "<sdf/>".into()),
        ("urdf-no-links", None, "<robot/>".into()),
        (
            "robot-no-moving-joint",
            None,
            "<robot><link name=\"a\"/></robot>".into(),
        ),
        ("urdf-missing-attribute", Some(4), robot("<link/>")),
        ("urdf-missing-attribute", Some(4), joint("name=\"j\"", "")),
        (
            "urdf-missing-element",
            Some(4),
            robot("<joint name=\"j\" type=\"fixed\"/>"),
        ),
        (
            "urdf-missing-element",
            Some(4),
            link("<inertial><mass value=\"1\"/></inertial>"),
        ),
        (
            "urdf-duplicate-inertial",
            Some(5),
            link(&format!("{INERTIAL}{INERTIAL}")),
        ),
    ]
}

/// Values that no robot has.
fn broken_values() -> Vec<Broken> {
    let revolute = r#"name="j" type="revolute""#;
    vec![
        (
            "robot-not-a-number",
            Some(4),
            joint(revolute, "<axis xyz=\"0 0 one\"/>"),
        ),
        (
            "robot-not-finite",
            Some(4),
            joint(revolute, "<limit effort=\"inf\"/>"),
        ),
        (
            "robot-number-too-large",
            Some(4),
            joint(revolute, "<origin xyz=\"0 0 1e21\"/>"),
        ),
        (
            "robot-wrong-count",
            Some(4),
            joint(revolute, "<axis xyz=\"0 1\"/>"),
        ),
        (
            "robot-zero-axis",
            Some(4),
            joint(revolute, "<axis xyz=\"0 0 -0\"/>"),
        ),
        (
            "robot-negative-mass",
            Some(4),
            link(&INERTIAL.replace("value=\"1\"", "value=\"-1\"")),
        ),
        (
            "robot-limits-reversed",
            Some(4),
            joint(revolute, "<limit lower=\"1\" upper=\"-1\"/>"),
        ),
    ]
}

/// Joints of a wrong kind, and links and joints that make no tree.
fn broken_trees() -> Vec<Broken> {
    let revolute = r#"name="j" type="revolute""#;
    let beside = |other: &str| robot(&format!("{JOINT}\n{other}"));
    let second = JOINT.replace("\"j\"", "\"k\"");
    vec![
        (
            "urdf-unknown-joint-type",
            Some(4),
            joint("name=\"j\" type=\"revolut\"", ""),
        ),
        (
            "robot-unknown-leader",
            Some(4),
            joint(revolute, "<mimic joint=\"k\"/>"),
        ),
        (
            "robot-leaders-in-circle",
            Some(4),
            joint(revolute, "<mimic joint=\"j\"/>"),
        ),
        (
            "urdf-missing-attribute",
            Some(4),
            joint(revolute, "<mimic multiplier=\"2\"/>"),
        ),
        (
            "urdf-xacro",
            Some(4),
            joint(revolute, "<limit effort=\"${effort}\"/>"),
        ),
        ("urdf-xacro", Some(4), robot("<xacro:arm prefix=\"left\"/>")),
        (
            "robot-duplicate-joint",
            Some(4),
            robot(&format!("{JOINT}{JOINT}")),
        ),
        ("robot-duplicate-link", Some(4), robot("<link name=\"a\"/>")),
        (
            "urdf-unknown-link",
            Some(5),
            beside(&second.replace("\"b\"", "\"d\"")),
        ),
        ("urdf-two-parents", Some(5), beside(&second)),
        (
            "urdf-cycle",
            None,
            beside(r#"<joint name="k" type="fixed"><parent link="b"/><child link="a"/></joint>"#),
        ),
        ("urdf-several-roots", None, robot("")),
        ("robot-too-many-joints", None, chain(MOST_JOINTS + 1)),
    ]
}

/// A chain of n joints.
fn chain(n: usize) -> String {
    let links: String = (0..=n).map(|k| format!("<link name=\"l{k}\"/>")).collect();
    let joint = |k| {
        let (parent, child) = (format!("l{k}"), format!("l{}", k + 1));
        format!(
            "<joint name=\"j{k}\" type=\"revolute\"><parent link=\"{parent}\"/><child link=\"{child}\"/></joint>"
        )
    };
    format!(
        "<robot>{links}{}</robot>",
        (0..n).map(joint).collect::<String>()
    )
}

/// Code and rows of each broken table.
const BROKEN_MDH: &[(&str, &str)] = &[
    ("mdh-not-readable", "[[joint]]\nname = 1"),
    ("robot-no-moving-joint", "joint = []"),
    (
        "robot-duplicate-joint",
        "[[joint]]\nname = \"a\"\n[[joint]]\nname = \"a\"",
    ),
    (
        "robot-duplicate-link",
        "[[joint]]\nname = \"a\"\nlink = \"l\"\n[[joint]]\nname = \"b\"\nlink = \"l\"",
    ),
    (
        "robot-duplicate-link",
        "[[joint]]\nname = \"a\"\nlink = \"base\"",
    ),
    ("robot-not-finite", "[[joint]]\nname = \"a\"\nlower = nan"),
    (
        "robot-not-finite",
        "[[joint]]\nname = \"a\"\ncom = [0.0, inf, 0.0]",
    ),
    (
        "robot-number-too-large",
        "[[joint]]\nname = \"a\"\nmass = 1e300",
    ),
    (
        "robot-negative-mass",
        "[[joint]]\nname = \"a\"\nmass = -1.0",
    ),
    (
        "robot-limits-reversed",
        "[[joint]]\nname = \"a\"\nlower = 1.0\nupper = 0.0",
    ),
    (
        "urdf-unknown-link",
        "[[joint]]\nname = \"a\"\nparent = \"b\"",
    ),
];

#[test]
fn broken_robot_files_are_refused_with_code_and_line() {
    let broken = [broken_elements(), broken_values(), broken_trees()];
    for (code, line, text) in broken.into_iter().flatten() {
        let fault = read_urdf(&text).expect_err(code);
        assert_eq!(fault.describe().code, code, "{fault}");
        assert_eq!(fault.place.line, line, "{fault}");
    }
    for (code, text) in BROKEN_MDH {
        let fault = read_mdh(text).expect_err(code);
        assert_eq!(fault.describe().code, *code, "{fault}");
    }
}

#[test]
fn a_duplicate_names_the_line_of_the_first_where_it_is_known() {
    let fault = read_urdf(&robot("<link name=\"b\"/>")).unwrap_err();
    assert!(fault.to_string().contains("at line 3 already"), "{fault}");
    let fault = read_mdh(BROKEN_MDH[2].1).unwrap_err();
    assert!(!fault.to_string().contains("line"), "{fault}");
}

#[test]
fn axes_of_any_length_become_unit_vectors() {
    for axis in ["0 3e19 4e19", "0 3e-170 4e-170", "0 3 4"] {
        let content = format!("<axis xyz=\"{axis}\"/>");
        let tree = read_urdf(&joint("name=\"j\" type=\"revolute\"", &content)).unwrap();
        let axis = tree.joints()[0].axis;
        assert!(
            (axis - nalgebra::Vector3::new(0.0, 0.6, 0.8)).norm() < 1e-15,
            "{axis}"
        );
    }
}

#[test]
fn the_longest_chain_is_read() {
    assert_eq!(read_urdf(&chain(MOST_JOINTS)).unwrap().len(), MOST_JOINTS);
}
