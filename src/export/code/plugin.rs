//! The drives as the source of an actuator plugin of MuJoCo: C whose numbers stand in the configuration of the plugin.

use crate::chain::effect::current_polynomial::LEAST_SLOPE;
use crate::chain::effect::expression::Expression;
use crate::export::code::layout::Layout;
use crate::export::code::names::{in_comment, quoted};
use crate::export::code::writer::Writer;
use crate::export::drive::{Drives, Gains};
use crate::export::error::ExportError;
use crate::export::identified::Identified;
use crate::export::language::Language;
use crate::export::term;
use crate::export::values::{Array, PlacedSetting, Setting, Values, combination};
use crate::outcome::provenance::VERSION;
use nalgebra::DMatrix;

/// The source and what its configuration holds.
#[derive(Debug)]
pub struct Plugin {
    pub source: String,
    pub settings: Vec<Setting>,
}

/// Derives where a cubic ceases to rise, in C.
const LAST_RISING: &str = "\
/* The first x > 0 at which the slope of c0 + c1 x + c2 x^2 + c3 x^3 falls to the given share of c1. */
static double last_rising(double c1, double c2, double c3, double share) {
    const double a = 3.0 * c3, b = 2.0 * c2, d = c1 - share * c1, discriminant = b * b - 4.0 * a * d;
    if (discriminant < 0.0) return INFINITY;
    const double root = sqrt(discriminant), first = 2.0 * d / (-b + root), second = 2.0 * d / (-b - root);
    double least = INFINITY;
    if (isfinite(first) && first > 0.0) least = first;
    if (isfinite(second) && second > 0.0 && second < least) least = second;
    return least;
}
";

/// The drives in C, and `glue` that calls them, with its change of speed for slopes.
///
/// # Errors
/// Effects or parameters that the result does not hold.
pub fn plugin(robot: Identified<'_>, glue: &str, change: f64) -> Result<Plugin, ExportError> {
    let Identified {
        name,
        machine,
        catalogue,
    } = robot;
    let mut drives = Drives::of(machine, catalogue, Values::Array(Array::default()))?;
    // The simulator holds back what is given to an actuator.
    drives.drives.iter_mut().for_each(|drive| drive.delay = 0.0);
    let layout = Layout::of(&drives);
    let writer = Writer {
        machine,
        language: Language::C,
        prefix: "exid",
        drives: &drives,
        layout: &layout,
    };
    let held_back = match machine.joints.iter().any(|joint| term::delay(joint) > 0.0) {
        true => "#define EXID_HELD_BACK 1\n",
        false => "",
    };
    let settings = drives.values.settings();
    let mut parts = vec![format!(
        "/* Drives of {}, written by exid {VERSION}, as an actuator plugin of MuJoCo. Compile and load it:\n\n   \
         MJ=$(python -c \"import mujoco, os; print(os.path.dirname(mujoco.__file__))\")\n   \
         cc -O2 -shared -fPIC -I$MJ/include exid_drive.c -o libexid_drive.so -L$MJ \
         -l:$(basename $MJ/libmujoco.so.?*) -lm\n   \
         python -c \"import mujoco; mujoco.mj_loadPluginLibrary('./libexid_drive.so')\"\n\n   \
         All numbers of the robot stand in model.xml, as `config` of the plugin: with others, compile nothing again. */\n\n\
         #include <locale.h>\n#include <math.h>\n#include <mujoco/mujoco.h>\n#include <stdint.h>\n#include <stdlib.h>\n\
         #include <string.h>\n\n#define EXID_JOINTS {}\n#define EXID_STATES {}\n#define EXID_SETTINGS {}\n\
         #define EXID_VALUES {}\n#define EXID_SPEED_CHANGE {change:?}\n{held_back}\n{}",
        in_comment(name),
        writer.joints(),
        layout.size,
        settings.len(),
        drives.values.count().max(1),
        Language::C.helpers()
    )];
    parts.push(keys(&settings));
    if drives.drives.iter().any(|drive| drive.current.is_some()) {
        parts.push(LAST_RISING.to_string());
    }
    parts.push(derivation(&drives));
    if !writer.members().is_empty() {
        parts.push(writer.drive_miss());
    }
    parts.push(writer.drive_step());
    parts.push(signals(&drives));
    parts.push(glue.to_string());
    Ok(Plugin {
        source: parts.join("\n"),
        settings: settings.into_iter().map(|placed| placed.setting).collect(),
    })
}

/// What the configuration has to hold.
fn keys(settings: &[PlacedSetting]) -> String {
    let number = |value: f64| Language::C.number(value);
    let rows = settings.iter().map(|PlacedSetting { setting, place }| {
        format!(
            "    {{{}, {place}, {}, {}}},\n",
            quoted(&setting.joint),
            number(setting.lower),
            number(setting.upper)
        )
    });
    let rows: String = rows.collect();
    let keys = settings.iter();
    let keys: String = keys
        .map(|placed| format!("    {},\n", quoted(&placed.setting.key)))
        .collect();
    format!(
        "/* Keys of the configuration. */\nstatic const char *const exid_keys[EXID_SETTINGS + 1] = {{\n{keys}    NULL\n}};\n\n\
         /* Of each key the joint, the place of its number among the values, and the numbers that its law allows. */\n\
         typedef struct {{\n    const char *joint;\n    int place;\n    double least, greatest;\n}} exid_setting;\n\n\
         static const exid_setting exid_settings[EXID_SETTINGS + 1] = {{\n{rows}    {{NULL, 0, 0.0, 0.0}}\n}};\n"
    )
}

/// What follows from the numbers of the configuration.
fn derivation(drives: &Drives) -> String {
    let formula = |of: &Expression| Language::C.formula(of);
    let mut text = "/* Values that follow from those of the configuration; what is wrong with them, or NULL. */\n\
                    static const char *exid_derive(double *p) {\n    (void)p;\n"
        .to_string();
    for current in drives
        .drives
        .iter()
        .filter_map(|drive| drive.current.as_ref())
    {
        let [_, c1, c2, c3] = current.coefficients.each_ref().map(formula);
        let end = formula(&current.end);
        text.push_str(&format!(
            "    {end} = last_rising({c1}, {c2}, {c3}, {LEAST_SLOPE:?});\n"
        ));
    }
    for (mixing, what) in [
        (&drives.coupling, "the coupling of the motors"),
        (&drives.crosstalk, "the crosstalk of the channels"),
    ] {
        if mixing.is_identity() {
            continue;
        }
        let n = drives.drives.len();
        let entries = |of: &DMatrix<Expression>| -> Vec<String> {
            let rows = of
                .row_iter()
                .flat_map(|row| row.iter().map(formula).collect::<Vec<_>>());
            rows.collect()
        };
        let first = formula(&mixing.inverse[(0, 0)]);
        text.push_str(&format!(
            "    for (int c = 0; c < {n}; c++) {{\n        double mixing[{}] = {{{}}}, column[{n}] = {{0.0}};\n        \
             column[c] = 1.0;\n        solve({n}, mixing, column);\n        for (int r = 0; r < {n}; r++) {{\n            \
             if (!isfinite(column[r])) return \"{what} has no inverse\";\n            \
             (&{first})[r * {n} + c] = column[r];\n        }}\n    }}\n",
            n * n,
            entries(&mixing.matrix).join(", ")
        ));
    }
    text + "    return NULL;\n}\n"
}

/// What position controllers make of commands, in C; robots without them are given signals.
fn signals(drives: &Drives) -> String {
    let mut text = "/* Signals of the motors from ctrl, where the joints are. */\nstatic void exid_signals(const double *p, \
                    const double *ctrl, const double *q, const double *v, double *signal) {\n    (void)p, (void)q, (void)v;\n"
        .to_string();
    let name = |text: String| Expression::name(text);
    let controlled = drives.gains.iter().any(Option::is_some);
    for (j, gains) in drives.gains.iter().enumerate() {
        let signal = match gains {
            None if controlled => Expression::Number(0.0),
            None => name(format!("ctrl[{j}]")),
            Some(Gains { kp, kd }) => combination(drives.coupling.inverse.row(j).iter(), |i| {
                let error = name(format!("ctrl[{i}]")) - name(format!("q[{i}]"));
                kp.clone() * error - kd.clone() * name(format!("v[{i}]"))
            }),
        };
        let signal = Language::C.formula(&signal);
        text.push_str(&format!("    signal[{j}] = {signal};\n"));
    }
    text + "}\n"
}
