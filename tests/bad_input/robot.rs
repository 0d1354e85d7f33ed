//! Robot files that break.

use crate::bench::Bench;
use crate::{Case, case};

/// One gigabyte.
const GIGABYTE: u64 = 1 << 30;

/// Replaces the whole robot file.
fn text(bench: &mut Bench, text: &str) {
    bench.write("arm.urdf", text);
}

/// Adds an element after the links.
fn element(bench: &mut Bench, element: &str) {
    bench.robot("</robot>", &format!("  {element}\n</robot>"));
}

fn joint(name: &str, parent: &str, child: &str) -> String {
    format!(
        "<joint name=\"{name}\" type=\"fixed\"><parent link=\"{parent}\"/><child link=\"{child}\"/></joint>"
    )
}

#[rustfmt::skip]
pub const CASES: &[Case] = &[
    case("no robot file", 3, ["none.urdf: ", "no such robot file", "relative to the problem file"], |b| b.problem("arm.urdf", "none.urdf")),
    case("a directory for a robot", 3, ["robots: ", "is a directory", "file inside"], |b| { b.folder("robots"); b.problem("arm.urdf", "robots"); }),
    case("an empty robot file", 3, ["arm.urdf: ", "is empty", "description into it"], |b| text(b, " \n")),
    case("a binary robot file", 3, ["arm.urdf: ", "not UTF-8", "save it as"], |b| b.write("arm.urdf", [0xff, 0xfe, 0x00])),
    case("a gigabyte of robot", 3, ["arm.urdf: ", "1073741824 bytes", "recording or mesh"], |b| b.sparse("arm.urdf", GIGABYTE)),
    case("a robot without end", 3, ["/dev/zero: ", "67108865 bytes", "recording or mesh"], |b| b.problem("arm.urdf", "/dev/zero")),
    case("a robot file nobody may read", 3, ["arm.urdf: ", "ermission denied", "check its permissions"], |b| b.forbid("arm.urdf", 0o000)),
    case("a truncated robot file", 3, ["arm.urdf:13:15", "unexpected end", "correct the XML"], |b| {
        let end = crate::common::arm::URDF.find("<mass value=\"2.0\"").unwrap();
        text(b, &crate::common::arm::URDF[..end + 8]);
    }),
    case("no XML", 3, ["arm.urdf:1:1", "not well-formed", "correct the XML"], |b| text(b, "mass = 3\n")),
    case("another kind of XML", 3, ["arm.urdf:1:1", "<sdf>", "give a URDF file"], |b| text(b, "<sdf/>")),
    case("no links", 3, ["arm.urdf: ", "has no links", "define links"], |b| text(b, "<robot/>")),
    case("a link without a name", 3, ["arm.urdf:2:3", "`name`", "add name="], |b| b.robot("<link name=\"base\"/>", "<link/>")),
    case("a joint without a child", 3, ["arm.urdf:17:3: shoulder", "<child>", "add <child"], |b| b.robot("<child link=\"upper\"/>", "")),
    case("text in a number", 3, ["arm.urdf:24:5: elbow", "`O.4`", "decimal number"], |b| b.robot("xyz=\"0.4", "xyz=\"O.4")),
    case("two of three numbers", 3, ["arm.urdf:24:5: elbow", "2 numbers", "write 3 numbers"], |b| b.robot("0.4 0 0", "0.4 0")),
    case("NaN in an inertia", 3, ["arm.urdf:7:7: upper", "`NaN`", "finite number"], |b| b.robot("iyy=\"0.06\"", "iyy=\"NaN\"")),
    case("a mass of a galaxy", 3, ["arm.urdf:6:7: upper", "`4e42`", "masses in kg"], |b| b.robot("value=\"4.0\"", "value=\"4e42\"")),
    case("a negative mass", 3, ["arm.urdf:6:7: upper", "-4 kg", "not negative"], |b| b.robot("value=\"4.0\"", "value=\"-4.0\"")),
    case("an inertia of no body", 3, ["arm.urdf: upper", "pseudo-inertia -", "triangle inequality"], |b| {
        b.robot("izz=\"0.06\"", "izz=\"0.6\"");
        b.problem("urdf = \"arm.urdf\"", "urdf = \"arm.urdf\"\ninertials = \"known\"");
    }),
    case("two inertials", 3, ["arm.urdf:16:3: base", "two <inertial>", "keep one"], |b| {
        let inertial = "<inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial>";
        b.robot("<link name=\"base\"/>", &format!("<link name=\"base\">{inertial}{}  {inertial}</link>", "\n".repeat(14)));
    }),
    case("two joints of one name", 3, ["arm.urdf:23:3: shoulder", "line 17 already", "its own name"], |b| b.robot("joint name=\"elbow\"", "joint name=\"shoulder\"")),
    case("two links of one name", 3, ["arm.urdf:10:3: upper", "line 3 already", "its own name"], |b| b.robot("link name=\"fore\"", "link name=\"upper\"")),
    case("a misspelled link", 3, ["arm.urdf:23:3: elbow", "`uper`", "mean `upper`?"], |b| b.robot("parent link=\"upper\"", "parent link=\"uper\"")),
    case("two parents", 3, ["arm.urdf:30:3: weld", "`fore`", "hangs on one joint"], |b| element(b, &joint("weld", "base", "fore"))),
    case("a circle of links", 3, ["arm.urdf: ", "in a circle", "cut the circle"], |b| element(b, &joint("weld", "fore", "base"))),
    case("two roots", 3, ["arm.urdf: ", "base, loose", "fixed joints"], |b| element(b, "<link name=\"loose\"/>")),
    case("no joint that moves", 3, ["arm.urdf: ", "no joint of the robot can move", "at least one joint"], |b| { b.robot("revolute", "fixed"); b.robot("revolute", "fixed"); }),
    case("a misspelled type", 3, ["arm.urdf:17:3: shoulder", "`revolut`", "mean `revolute`?"], |b| b.robot("type=\"revolute\"", "type=\"revolut\"")),
    case("macros that are not expanded", 3, ["arm.urdf:17:3", "xacro macros", "`xacro robot.urdf.xacro > robot.urdf`"], |b| b.robot("joint name=\"shoulder\"", "joint name=\"${side}_shoulder\"")),
    case("a joint that follows none", 3, ["arm.urdf:30:3: elbow", "`sholder`", "mean `shoulder`?"], |b| b.robot("effort=\"50\"/>\n", "effort=\"50\"/>\n<!-- -->\n  <mimic joint=\"sholder\"/>")),
    case("joints that follow each other", 3, ["arm.urdf:30:3: elbow", "elbow", "let one of them"], |b| b.robot("effort=\"50\"/>\n", "effort=\"50\"/>\n<!-- -->\n  <mimic joint=\"elbow\"/>")),
    case("an axis without length", 3, ["arm.urdf:17:3: shoulder", "no length", "xyz=\"0 0 1\""], |b| b.robot("0 1 0", "0 0 0")),
    case("limits the wrong way round", 3, ["arm.urdf:17:3: shoulder", "lower limit 3 is above the upper limit -3", "exchange"], |b| b.robot("lower=\"-3.0\" upper=\"3.0\"", "lower=\"3.0\" upper=\"-3.0\"")),
    case("a table that is none", 3, ["arm.mdh.toml:1:", "cannot be read", "README"], |b| { b.write("arm.mdh.toml", "joint = 3\n"); b.problem("urdf = \"arm.urdf\"", "mdh = \"arm.mdh.toml\""); }),
];
