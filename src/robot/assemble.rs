//! From the links and joints of a file to a tree: names, parents, circles, fixed joints merged.

use crate::fault::{Place, nearest};
use crate::robot::error::{RobotError, RobotErrorKind};
use crate::robot::inertia::Inertia;
use crate::robot::tree::{Frame, Joint, JointKind, Limits, Tree};
use nalgebra::{Isometry3, Vector3};
use std::collections::HashMap;
use std::path::Path;

/// Most moving joints of a robot: memory grows with the square, and robots have a tenth of it.
pub(crate) const MOST_JOINTS: usize = 1000;

/// A link as its file describes it; the inertia is about the link's own frame.
#[derive(Debug, Clone)]
pub(crate) struct RawLink {
    pub name: String,
    /// Offset of the element in the file, bytes.
    pub at: usize,
    pub inertia: Inertia,
}

/// A joint as its file describes it; `kind` is `None` for a fixed one.
#[derive(Debug, Clone)]
pub(crate) struct RawJoint {
    pub name: String,
    /// Offset of the element in the file, bytes.
    pub at: usize,
    pub kind: Option<JointKind>,
    pub parent: String,
    pub child: String,
    pub axis: Vector3<f64>,
    pub origin: Isometry3<f64>,
    pub limits: Limits,
}

/// A robot as its file describes it.
#[derive(Debug, Clone)]
pub(crate) struct RawRobot<'a> {
    pub path: &'a Path,
    pub name: String,
    pub links: Vec<RawLink>,
    pub joints: Vec<RawJoint>,
}

/// Builds the tree, joints in the order in which a walk from the base meets them. `locate` gives the
/// place of an element by its offset: a search through the file, made for faults only.
pub(crate) fn assemble(
    robot: &RawRobot<'_>,
    locate: impl Fn(usize) -> Place,
) -> Result<Tree, RobotError> {
    let fail = |kind| RobotError::new(Place::file(robot.path), kind);
    if robot.links.is_empty() {
        return Err(fail(RobotErrorKind::NoLinks));
    }
    let moving = robot.joints.iter().filter(|j| j.kind.is_some()).count();
    if moving > MOST_JOINTS {
        return Err(fail(RobotErrorKind::TooManyJoints {
            found: moving,
            limit: MOST_JOINTS,
        }));
    }
    let index = link_index(&robot.links, &locate)?;
    let parent_joint = parent_joints(robot, &index, &locate)?;
    let root = single_root(robot, &parent_joint).map_err(fail)?;
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); robot.links.len()];
    for (k, joint) in robot.joints.iter().enumerate() {
        children[index[joint.parent.as_str()]].push(k);
    }
    let mut walk = Walk {
        robot,
        index: &index,
        children: &children,
        joints: Vec::new(),
        frames: Vec::new(),
        visited: vec![false; robot.links.len()],
    };
    walk.visit(root, None, Isometry3::identity());
    let (joints, frames, visited) = (walk.joints, walk.frames, walk.visited);
    if let Some(stray) = visited.iter().position(|seen| !seen) {
        let links = circle(robot, &index, &parent_joint, stray);
        return Err(fail(RobotErrorKind::Cycle { links }));
    }
    if joints.is_empty() {
        return Err(fail(RobotErrorKind::NoMovingJoint));
    }
    let base = robot.links[root].name.clone();
    Ok(Tree::new(robot.name.clone(), base, joints).with_frames(frames))
}

/// The joint that carries each link; `None` for a link without parent.
fn parent_joints(
    robot: &RawRobot<'_>,
    index: &HashMap<&str, usize>,
    locate: &impl Fn(usize) -> Place,
) -> Result<Vec<Option<usize>>, RobotError> {
    let mut joint_names: HashMap<&str, usize> = HashMap::new();
    let mut parent_joint: Vec<Option<usize>> = vec![None; robot.links.len()];
    for (k, joint) in robot.joints.iter().enumerate() {
        let at = |kind| RobotError::new(locate(joint.at).key(&joint.name), kind);
        if let Some(first) = joint_names.insert(&joint.name, joint.at) {
            let first_line = locate(first).line;
            return Err(at(RobotErrorKind::DuplicateJoint { first_line }));
        }
        let find = |name: &str| {
            index.get(name).copied().ok_or_else(|| {
                at(RobotErrorKind::UnknownLink {
                    found: name.to_string(),
                    nearest: nearest(name, robot.links.iter().map(|l| l.name.as_str())),
                })
            })
        };
        find(&joint.parent)?;
        let child = find(&joint.child)?;
        if let Some(other) = parent_joint[child].replace(k) {
            return Err(at(RobotErrorKind::TwoParents {
                link: joint.child.clone(),
                other: robot.joints[other].name.clone(),
            }));
        }
    }
    Ok(parent_joint)
}

fn link_index<'a>(
    links: &'a [RawLink],
    locate: &impl Fn(usize) -> Place,
) -> Result<HashMap<&'a str, usize>, RobotError> {
    let mut index: HashMap<&str, usize> = HashMap::new();
    for (k, link) in links.iter().enumerate() {
        if let Some(first) = index.insert(&link.name, k) {
            let first_line = locate(links[first].at).line;
            return Err(RobotError::new(
                locate(link.at).key(&link.name),
                RobotErrorKind::DuplicateLink { first_line },
            ));
        }
    }
    Ok(index)
}

fn single_root(
    robot: &RawRobot<'_>,
    parent_joint: &[Option<usize>],
) -> Result<usize, RobotErrorKind> {
    let names = |k: usize| robot.links[k].name.clone();
    let roots: Vec<usize> = (0..robot.links.len())
        .filter(|&k| parent_joint[k].is_none())
        .collect();
    match roots[..] {
        [root] => Ok(root),
        [] => Err(RobotErrorKind::Cycle {
            links: (0..robot.links.len()).map(names).collect(),
        }),
        _ => Err(RobotErrorKind::SeveralRoots {
            roots: roots.into_iter().map(names).collect(),
        }),
    }
}

/// The links of the circle that a link without way to the base hangs on.
fn circle(
    robot: &RawRobot<'_>,
    index: &HashMap<&str, usize>,
    parent_joint: &[Option<usize>],
    start: usize,
) -> Vec<String> {
    let mut seen = Vec::new();
    let mut at = start;
    while !seen.contains(&at) {
        seen.push(at);
        match parent_joint[at] {
            Some(joint) => at = index[robot.joints[joint].parent.as_str()],
            None => break,
        }
    }
    let first = seen.iter().position(|&k| k == at).unwrap_or(0);
    seen[first..]
        .iter()
        .map(|&k| robot.links[k].name.clone())
        .collect()
}

struct Walk<'a> {
    robot: &'a RawRobot<'a>,
    index: &'a HashMap<&'a str, usize>,
    children: &'a [Vec<usize>],
    joints: Vec<Joint>,
    frames: Vec<Frame>,
    visited: Vec<bool>,
}

impl Walk<'_> {
    /// Visits a link that stands at `placement` in the link of moving joint `carrier`.
    fn visit(&mut self, link: usize, carrier: Option<usize>, placement: Isometry3<f64>) {
        // An explicit stack: a chain of many thousand links must not exhaust the call stack.
        let mut stack = vec![(link, carrier, placement)];
        while let Some((link, carrier, placement)) = stack.pop() {
            self.visited[link] = true;
            let mut next = Vec::new();
            for &k in &self.children[link] {
                let raw = &self.robot.joints[k];
                let child = self.index[raw.child.as_str()];
                let at = placement * raw.origin;
                next.push((child, raw, carrier, at));
            }
            for (child, raw, carrier, at) in next.into_iter().rev() {
                match raw.kind {
                    None => {
                        self.merge(child, carrier, at);
                        stack.push((child, carrier, at));
                    }
                    Some(kind) => stack.push(self.moving(child, raw, carrier, kind, at)),
                }
            }
        }
        self.sort();
    }

    fn merge(&mut self, child: usize, carrier: Option<usize>, at: Isometry3<f64>) {
        let link = &self.robot.links[child];
        if let Some(carrier) = carrier {
            let moved = link
                .inertia
                .seen_from(&at.rotation.to_rotation_matrix(), &at.translation.vector);
            let joint = &mut self.joints[carrier];
            joint.inertia = joint.inertia.plus(&moved);
        }
        self.frames.push(Frame {
            name: link.name.clone(),
            joint: carrier,
            placement: at,
        });
    }

    fn moving(
        &mut self,
        child: usize,
        raw: &RawJoint,
        carrier: Option<usize>,
        kind: JointKind,
        at: Isometry3<f64>,
    ) -> (usize, Option<usize>, Isometry3<f64>) {
        let link = &self.robot.links[child];
        self.joints.push(Joint {
            name: raw.name.clone(),
            link: link.name.clone(),
            parent: carrier,
            kind,
            axis: raw.axis,
            rotation: at.rotation.to_rotation_matrix(),
            translation: at.translation.vector,
            limits: raw.limits,
            inertia: link.inertia,
        });
        (child, Some(self.joints.len() - 1), Isometry3::identity())
    }

    /// Brings the joints into the order of a walk in depth, each after its parent.
    fn sort(&mut self) {
        let n = self.joints.len();
        let mut order = Vec::with_capacity(n);
        let mut stack: Vec<usize> = self.sons(None);
        while let Some(k) = stack.pop() {
            order.push(k);
            stack.extend(self.sons(Some(k)));
        }
        let mut place = vec![0; n];
        for (new, &old) in order.iter().enumerate() {
            place[old] = new;
        }
        let mut sorted: Vec<Joint> = order.iter().map(|&k| self.joints[k].clone()).collect();
        for joint in &mut sorted {
            joint.parent = joint.parent.map(|p| place[p]);
        }
        for frame in &mut self.frames {
            frame.joint = frame.joint.map(|k| place[k]);
        }
        self.joints = sorted;
    }

    /// The joints that hang on joint `of`, the first of the file last.
    fn sons(&self, of: Option<usize>) -> Vec<usize> {
        let position = |k: &usize| {
            let name = &self.joints[*k].name;
            self.robot.joints.iter().position(|j| &j.name == name)
        };
        let mut sons: Vec<usize> = (0..self.joints.len())
            .filter(|&k| self.joints[k].parent == of)
            .collect();
        sons.sort_by_key(position);
        sons.reverse();
        sons
    }
}
