//! A planar arm keeps a distance between the collision shapes of its URDF, by the distance of segments worked out
//! here again.

use crate::bench::Bench;

/// A shoulder at 0.4 m over a pedestal; the forearm can fold down onto it.
const URDF: &str = r#"<robot name="arm">
  <link name="base">
    <collision><origin xyz="0.25 0 -0.15"/><geometry><sphere radius="0.12"/></geometry></collision>
  </link>
  <link name="upper">
    <inertial><origin xyz="0.2 0 0"/><mass value="4"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.06" iyz="0" izz="0.06"/></inertial>
  </link>
  <link name="fore">
    <inertial><origin xyz="0.15 0 0.02"/><mass value="2"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial>
    <collision>
      <origin xyz="0.15 0 0" rpy="0 1.5707963267948966 0"/><geometry><cylinder radius="0.04" length="0.3"/></geometry>
    </collision>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit lower="-2.5" upper="1.0" velocity="3" effort="80"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper"/><child link="fore"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-2.6" upper="2.6" velocity="3" effort="40"/>
  </joint>
</robot>
"#;

const PROBLEM: &str = r#"name = "arm"

[robot]
urdf = "arm.urdf"

[design]
harmonics = 3
period = 6.0
starts = 3
rest_to_rest = false

[design.limits]
acceleration = [12.0, 12.0]
"#;

const RULE: &str = r#"
[[design.workspace.clearance]]
links = ["base", "fore"]
distance = 0.05
"#;

/// m: radii of sphere and cylinder, and the distance asked for.
const KEPT: f64 = 0.12 + 0.04 + 0.05;

/// Distance from the sphere's centre to the axis of the forearm's cylinder, m, along the whole motion.
fn nearest(rows: &[Vec<f64>]) -> f64 {
    let (centre, upper, fore) = ([0.25, -0.15], 0.4, 0.3);
    let along = |row: &Vec<f64>| -> f64 {
        // A turn by q about y takes x to (cos q, −sin q) in the plane of x and z.
        let (first, both) = (row[1], row[1] + row[2]);
        let from = [upper * first.cos(), -upper * first.sin()];
        let direction = [both.cos(), -both.sin()];
        let to = [centre[0] - from[0], centre[1] - from[1]];
        let reach = (to[0] * direction[0] + to[1] * direction[1]).clamp(0.0, fore);
        let off = [to[0] - reach * direction[0], to[1] - reach * direction[1]];
        off[0].hypot(off[1])
    };
    rows.iter().map(along).fold(f64::INFINITY, f64::min)
}

#[test]
fn invariant_a_design_keeps_the_distance_between_collision_shapes_of_the_robot_file() {
    let free = Bench::new(PROBLEM, URDF);
    free.design("out", &[], 0);
    let without = nearest(&free.trajectory("out", "trajectory.csv"));
    let bench = Bench::new(&format!("{PROBLEM}{RULE}"), URDF);
    let result = bench.design("out", &[], 0);
    let kept = nearest(&bench.trajectory("out", "trajectory.csv"));
    println!(
        "axis of the forearm to the pedestal: {kept:.4} m kept, {without:.4} m without the rule, limit {KEPT:.4} m"
    );
    assert!(
        without < KEPT,
        "the rule would not have mattered: {without}"
    );
    // A thousandth of the limits between samples.
    assert!(kept >= KEPT - 1e-3, "{kept}");
    let margins = result["worst_margins"].as_array().unwrap();
    let own = margins
        .iter()
        .find(|m| m["constraint"] == "clearance of base and fore")
        .unwrap();
    let margin = own["margin"].as_f64().unwrap();
    // Samples of the trajectory file miss the dense grid's nearest instant by less than a millimetre.
    assert!((margin - (kept - KEPT)).abs() < 1e-3, "{margin} and {kept}");
}
