//! MJCF files that break, each with its own words.

use exid::fault::Fault;
use exid::robot::mjcf;
use std::fs;

/// What is wrong with a file: the code, line of the main file, part of the message, and the text.
struct Broken {
    code: &'static str,
    line: Option<usize>,
    says: &'static str,
    text: String,
}

/// A sound model with one body; `{}` in turn: compiler, default, asset, the inside of the body, the end.
fn model(parts: [&str; 5]) -> String {
    let [compiler, default, asset, body, end] = parts;
    format!(
        "<mujoco>\n{compiler}\n<default>{default}</default>\n<asset>{asset}</asset>\n<worldbody>\n<body name=\"b\">\n{body}\n\
         </body>\n</worldbody>\n{end}\n</mujoco>\n"
    )
}

fn compiler(text: &str) -> String {
    model([text, "", "", "<joint/><geom size=\"1\"/>", ""])
}

fn default(text: &str) -> String {
    model(["", text, "", "<joint/><geom size=\"1\"/>", ""])
}

fn body(text: &str) -> String {
    model(["", "", "", text, ""])
}

fn mesh(asset: &str) -> String {
    model([
        "",
        "",
        asset,
        "<joint/><geom type=\"mesh\" mesh=\"m\"/>",
        "",
    ])
}

fn end(text: &str) -> String {
    model(["", "", "", "<joint name=\"j\"/><geom size=\"1\"/>", text])
}

fn broken(
    code: &'static str,
    line: impl Into<Option<usize>>,
    says: &'static str,
    text: String,
) -> Broken {
    Broken {
        code,
        line: line.into(),
        says,
        text,
    }
}

#[rustfmt::skip]
fn files() -> Vec<Broken> {
    let plain = |text: &str| text.to_string();
    let inertial = |attributes: &str| body(&format!("<joint/><inertial {attributes}/>"));
    vec![
        broken("urdf-not-xml", 1, "not well-formed", plain("<mujoco><worldbody>")),
        broken("mjcf-not-mujoco", 1, "robot.urdf", plain("<robot name=\"r\"/>")),
        broken("mjcf-not-mujoco", 1, "<sdf>", plain("<sdf/>")),
        broken("mjcf-no-worldbody", 1, "<worldbody>", plain("<mujoco/>")),
        broken("robot-no-moving-joint", None, "no joint", plain("<mujoco><worldbody><body/></worldbody></mujoco>")),
        broken("mjcf-missing-attribute", 2, "`file`", compiler("<include/>")),
        broken("mjcf-not-included", 2, "part.xml", compiler("<include file=\"part.xml\"/>")),
        broken("mjcf-included-twice", 2, "model.xml", compiler("<include file=\"model.xml\"/>")),
        broken("mjcf-unknown-attribute", 2, "`angle`?", compiler("<compiler angel=\"radian\"/>")),
        broken("mjcf-not-a-word", 2, "radian, degree", compiler("<compiler angle=\"rad\"/>")),
        broken("mjcf-eulerseq", 2, "`xyw`", compiler("<compiler eulerseq=\"xyw\"/>")),
        broken("mjcf-global-coordinates", 2, "older MuJoCo", compiler("<compiler coordinate=\"global\"/>")),
        broken("mjcf-negative", 2, "boundmass is -1", compiler("<compiler boundmass=\"-1\"/>")),
        broken("mjcf-wrong-count", 2, "gravity has 2", compiler("<option gravity=\"0 1\"/>")),
        broken("mjcf-class-without-name", 3, "no name", default("<default/>")),
        broken("mjcf-class-twice", 3, "`c`", default("<default class=\"c\"/><default class=\"c\"/>")),
        broken("mjcf-unknown-class", 7, "mean `arms`?", model(["", "<default class=\"arms\"/>", "", "<joint class=\"arm\"/>", ""])),
        broken("mjcf-unknown-class", 7, "`hand`", body("<joint/><body childclass=\"hand\"/>")),
        broken("mjcf-unknown-element", 7, "mean `joint`?", body("<jiont/>")),
        broken("mjcf-unsupported", 7, "to_xml()", body("<joint/><replicate count=\"3\"><geom/></replicate>")),
        broken("mjcf-unsupported", 7, "deformable", body("<joint/><flexcomp/>")),
        broken("mjcf-unknown-attribute", 7, "`armature`?", body("<joint amature=\"1\"/>")),
        broken("robot-zero-axis", 7, "no length", body("<joint axis=\"0 0 0\"/>")),
        broken("robot-limits-reversed", 7, "exchange", body("<joint range=\"1 -1\"/>")),
        broken("robot-not-a-number", 7, "`1,5`", body("<joint damping=\"1,5\"/>")),
        broken("robot-not-finite", 7, "finite", body("<joint pos=\"0 0 nan\"/>")),
        broken("robot-number-too-large", 7, "masses in kg", inertial("pos=\"0 0 0\" mass=\"1e30\" diaginertia=\"1 1 1\"")),
        broken("mjcf-negative", 7, "frictionloss is -2", body("<joint frictionloss=\"-2\"/>")),
        broken("mjcf-unsupported", 7, "springdamper", body("<joint springdamper=\"0.1 1\"/>")),
        broken("robot-duplicate-joint", 7, "its own name", body("<joint name=\"j\"/><joint name=\"j\"/>")),
        broken("robot-duplicate-link", 7, "its own name", body("<joint/><body name=\"b\"/>")),
        broken("mjcf-free-among-others", 7, "other joints", body("<freejoint/><joint/>")),
        broken("mjcf-free-not-in-world", 7, "<worldbody>", body("<joint/><body><freejoint/></body>")),
        broken("mjcf-two-orientations", 7, "quat and by euler", body("<joint/><body quat=\"1 0 0 0\" euler=\"1 2 3\"/>")),
        broken("mjcf-no-direction", 7, "zaxis", body("<joint/><body zaxis=\"0 0 0\"/>")),
        broken("mjcf-missing-attribute", 7, "`pos`", inertial("mass=\"1\" diaginertia=\"1 1 1\"")),
        broken("mjcf-missing-attribute", 7, "`mass`", inertial("pos=\"0 0 0\" diaginertia=\"1 1 1\"")),
        broken("robot-negative-mass", 7, "-1 kg", inertial("pos=\"0 0 0\" mass=\"-1\" diaginertia=\"1 1 1\"")),
        broken("mjcf-no-inertia", 7, "diaginertia", inertial("pos=\"0 0 0\" mass=\"1\"")),
        broken("mjcf-inertia-twice", 7, "keep one", inertial("pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\" fullinertia=\"1 1 1 0 0 0\"")),
        broken("mjcf-turned-full-inertia", 7, "axes of the body", inertial("pos=\"0 0 0\" mass=\"1\" fullinertia=\"1 1 1 0 0 0\" quat=\"1 0 0 0\"")),
        broken("mjcf-not-positive-inertia", 7, "-1.000e0", inertial("pos=\"0 0 0\" mass=\"1\" fullinertia=\"1 1 1 2 0 0\"")),
        broken("mjcf-inertial-twice", 7, "keep one", body("<joint/><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/><inertial/>")),
        broken("mjcf-size", 7, "first 3", body("<joint/><geom type=\"box\" size=\"1 1\"/>")),
        broken("mjcf-unsupported", 7, "signed distance", body("<joint/><geom type=\"sdf\"/>")),
        broken("mjcf-unknown-mesh", 7, "`m`", mesh("")),
        broken("mjcf-mesh-twice", 4, "`m`", mesh("<mesh name=\"m\"/><mesh name=\"m\"/>")),
        broken("mjcf-mesh-file", 4, "m.obj", mesh("<mesh file=\"m.obj\"/>")),
        broken("mjcf-mesh-file", 4, "obj nor stl", mesh("<mesh name=\"m\" file=\"model.xml\"/>")),
        broken("mjcf-mesh-file", 4, "does not exist", mesh("<mesh name=\"m\" vertex=\"0 0 0 1 0 0 0 1 0\" face=\"0 1 7\"/>")),
        broken("mjcf-no-volume", 4, "no volume", mesh("<mesh name=\"m\" vertex=\"0 0 0 1 0 0 0 1 0\" face=\"0 1 2\"/>")),
        broken("mjcf-mesh-not-closed", 4, "outwards", mesh("<mesh name=\"m\" inertia=\"exact\" vertex=\"0 0 0 1 0 0 0 1 0 0 0 1\" face=\"0 1 2 0 3 1 1 3 2 2 3 0\"/>")),
        broken("mjcf-unknown-joint", 9 + 1, "mean `j`?", end("<equality><joint joint1=\"jj\"/></equality>")),
        broken("mjcf-missing-attribute", 10, "joint1", end("<equality><joint joint2=\"j\"/></equality>")),
        broken("robot-leaders-in-circle", 10, "circle", end("<equality><joint joint1=\"j\" joint2=\"j\"/></equality>")),
        broken("mjcf-unknown-joint", 10, "`k`", end("<actuator><motor joint=\"k\"/></actuator>")),
    ]
}

#[test]
fn every_broken_file_has_its_own_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.xml");
    let files = files();
    assert!(files.len() >= 50);
    let mut faults = Vec::new();
    for Broken {
        code,
        line,
        says,
        text,
    } in files
    {
        fs::write(&path, &text).unwrap();
        let Err(error) = mjcf::read(&path) else {
            faults.push(format!("{code}: no error\n{text}"));
            continue;
        };
        let found = (error.describe().code, error.place.line);
        let whole = error.to_string();
        if found != (code, line) || !whole.contains(says) {
            faults.push(format!("{code} at {line:?}, `{says}`: {found:?} {whole}"));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn what_is_left_out_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.xml");
    for (text, says) in [
        (
            end("<tendon><fixed stiffness=\"3\"><joint joint=\"j\" coef=\"1\"/></fixed></tendon>"),
            "stiffness of a tendon",
        ),
        (
            end("<equality><connect body1=\"b\" anchor=\"0 0 0\"/></equality>"),
            "loop that it closes is open",
        ),
        (
            end("<equality><joint joint1=\"j\" polycoef=\"0.1 1 2\"/></equality>"),
            "",
        ),
        (
            body("<joint damping=\"1 2\"/><geom size=\"1\"/>"),
            "damping beyond the linear",
        ),
        (compiler("<option density=\"1.2\"/>"), "medium"),
        (
            end("<equality><weld active=\"false\" body1=\"b\"/></equality>"),
            "",
        ),
    ] {
        fs::write(&path, &text).unwrap();
        let robot = mjcf::read(&path).unwrap_or_else(|e| panic!("{e}"));
        let said: Vec<String> = robot.notes.iter().map(|note| note.to_string()).collect();
        match says {
            "" => assert!(said.is_empty(), "{said:?}"),
            says => assert!(said.len() == 1 && said[0].contains(says), "{said:?}"),
        }
    }
}
