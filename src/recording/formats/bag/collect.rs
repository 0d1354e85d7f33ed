//! From messages to columns: first what a bag holds, then the rows of one topic.

use std::collections::BTreeMap;
use std::path::Path;

use crate::fault::Place;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::formats::bag::joint_state::{Encoding, JointState};
use crate::recording::formats::reading::Reading;
use crate::recording::formats::table::{Origin, Table, require_rows};

/// What a container hands over.
pub(super) enum Entry<'a> {
    /// A topic and the type of its messages, as the container names it.
    Topic { topic: &'a str, kind: &'a str },
    /// A message on a topic that carries joint states.
    Message(Message<'a>),
}

/// A message of type sensor_msgs/JointState.
pub(super) struct Message<'a> {
    pub topic: &'a str,
    /// Time of recording, ns.
    pub logged: i64,
    pub encoding: Encoding,
    pub bytes: &'a [u8],
}

/// Takes what a container hands over; its errors end the reading.
pub(super) type Take<'t> = dyn FnMut(Entry) -> Result<(), String> + 't;

/// Hands over the topics and joint states of a file; errors in words.
pub(super) type Container = fn(&Path, &Reading, &mut Take) -> Result<(), RecordingError>;

/// Whether a type is that of joint states, in the names of ROS 1 and of ROS 2.
pub(super) fn is_joint_state(kind: &str) -> bool {
    matches!(
        kind,
        "sensor_msgs/JointState" | "sensor_msgs/msg/JointState"
    )
}

/// Channels of a joint in a message, as their columns begin.
const CHANNELS: [&str; 3] = ["position", "velocity", "effort"];
const TIME: &str = "t";
const LOG_TIME: &str = "log_t";

/// What one topic holds.
#[derive(Debug, Clone, Default, PartialEq)]
struct Survey {
    /// Joints in the order of their first message.
    joints: Vec<String>,
    /// For each joint: whether position, velocity and effort hold numbers.
    present: Vec<[bool; 3]>,
    stamped: bool,
}

impl Survey {
    fn add(&mut self, state: &JointState) {
        self.stamped |= state.stamp != 0;
        for (k, name) in state.names.iter().enumerate() {
            // Messages mostly name the joints in one order: the same place is tried first.
            let same = self.joints.get(k).is_some_and(|joint| joint == name);
            let known = if same { Some(k) } else { None };
            let joint = known.or_else(|| self.joints.iter().position(|joint| joint == name));
            let joint = joint.unwrap_or_else(|| {
                self.joints.push(name.clone());
                self.present.push([false; 3]);
                self.joints.len() - 1
            });
            for (present, values) in self.present[joint].iter_mut().zip(&state.channels) {
                *present |= values.get(k).is_some_and(|value| value.is_finite());
            }
        }
    }

    fn columns(&self) -> Vec<String> {
        let mut columns = vec![TIME.to_string(), LOG_TIME.to_string()];
        for (c, channel) in CHANNELS.iter().enumerate() {
            let joints = self.joints.iter().zip(&self.present);
            let held = joints.filter(|(_, present)| present[c]);
            columns.extend(held.map(|(joint, _)| format!("{channel}_{joint}")));
        }
        columns
    }
}

/// The topics with joint states, in the order of their names.
struct Contents {
    surveys: BTreeMap<String, Survey>,
}

impl Contents {
    /// Errors: those of the container, a message that cannot be decoded, no joint state at all.
    fn survey(
        path: &Path,
        reading: &Reading,
        container: Container,
    ) -> Result<Self, RecordingError> {
        let mut topics = BTreeMap::new();
        let mut surveys: BTreeMap<String, Survey> = BTreeMap::new();
        container(path, reading, &mut |entry| {
            match entry {
                Entry::Topic { topic, kind } => {
                    topics.insert(topic.to_string(), kind.to_string());
                }
                Entry::Message(message) => {
                    let state = JointState::decode(message.bytes, message.encoding)?;
                    match surveys.get_mut(message.topic) {
                        Some(survey) => survey.add(&state),
                        None => surveys.entry(message.topic.into()).or_default().add(&state),
                    }
                }
            }
            Ok(())
        })?;
        if surveys.is_empty() {
            let named = topics
                .iter()
                .map(|(topic, kind)| format!("{topic} ({kind})"));
            let kind = RecordingErrorKind::NoJointState {
                present: named.collect(),
            };
            return Err(RecordingError::new(Place::file(path), kind));
        }
        Ok(Self { surveys })
    }

    /// Each column as topic, name in that topic and name for the user.
    fn columns(&self) -> Vec<(&str, String, String)> {
        let several = self.surveys.len() > 1;
        let mut columns = Vec::new();
        for (topic, survey) in &self.surveys {
            for column in survey.columns() {
                let shown = match several {
                    true => format!("{topic}:{column}"),
                    false => column.clone(),
                };
                columns.push((topic.as_str(), column, shown));
            }
        }
        columns
    }
}

/// Names of all columns of a bag.
pub(super) fn columns(
    path: &Path,
    reading: &Reading,
    container: Container,
) -> Result<Vec<String>, RecordingError> {
    let contents = Contents::survey(path, reading, container)?;
    Ok(contents.columns().into_iter().map(|c| c.2).collect())
}

/// The wanted columns of a bag, in the order of the times of recording.
///
/// Errors: those of the container, columns of two topics, a message with some of the wanted joints
/// only, too few rows.
pub(super) fn read(
    path: &Path,
    reading: &Reading,
    wanted: &[String],
    container: Container,
) -> Result<Table, RecordingError> {
    let contents = Contents::survey(path, reading, container)?;
    let columns = contents.columns();
    let chosen: Vec<_> = wanted
        .iter()
        .filter_map(|name| columns.iter().find(|column| column.2 == *name))
        .collect();
    let topic = chosen.first().map_or("", |column| column.0);
    if let Some(other) = chosen.iter().find(|column| column.0 != topic) {
        let kind = RecordingErrorKind::TwoTopics {
            topics: vec![topic.into(), other.0.into()],
        };
        let place = Place::file(path).key(other.2.as_str());
        return Err(RecordingError::new(place, kind));
    }
    let names: Vec<&str> = chosen.iter().map(|column| column.1.as_str()).collect();
    let channel = |name: &String| {
        let of_name = chosen.iter().find(|column| column.2 == *name);
        of_name.map_or("", |column| column.1.as_str())
    };
    let stamped = contents.surveys.get(topic).is_some_and(|s| s.stamped);
    let rows = collect_rows(path, reading, container, topic, &names)?;
    require_rows(path, rows.len())?;
    let data = (0..names.len()).map(|c| match names[c] {
        TIME if stamped => seconds(rows.iter().map(|row| row.stamp)),
        TIME | LOG_TIME => seconds(rows.iter().map(|row| row.logged)),
        _ => rows.iter().map(|row| row.values[c]).collect(),
    });
    let data = data.collect();
    let begin = |name: &String| {
        let first = rows.first()?;
        let nanoseconds = match channel(name) {
            TIME if stamped => first.stamp,
            TIME | LOG_TIME => first.logged,
            _ => return None,
        };
        Some(Origin {
            column: name.clone(),
            nanoseconds,
        })
    };
    Ok(Table {
        columns: wanted.to_vec(),
        data,
        first_line: 1,
        lines: None,
        origins: wanted.iter().filter_map(begin).collect(),
    })
}

/// Seconds since the first of these, which are in ns: differences first, because seconds since 1970
/// leave no digits for microseconds.
fn seconds(times: impl Iterator<Item = i64>) -> Vec<f64> {
    let mut origin = None;
    times
        .map(|time| time.wrapping_sub(*origin.get_or_insert(time)) as f64 * 1e-9)
        .collect()
}

/// One message as numbers, in the order of the wanted columns; a time has no number here.
struct Row {
    logged: i64,
    stamp: i64,
    values: Vec<f64>,
}

/// The messages of a topic with the wanted joints. A topic may have several senders, such as an arm
/// and its gripper: messages with none of the wanted joints are passed over.
fn collect_rows(
    path: &Path,
    reading: &Reading,
    container: Container,
    topic: &str,
    names: &[&str],
) -> Result<Vec<Row>, RecordingError> {
    let mut rows: Vec<Row> = Vec::new();
    let mut stop = None;
    let collected = container(path, reading, &mut |entry| {
        let Entry::Message(message) = entry else {
            return Ok(());
        };
        if let Err(error) = reading.takes_rows(path, rows.len() + 1) {
            stop = Some(error);
            return Err("too many".into());
        }
        if message.topic == topic {
            let state = JointState::decode(message.bytes, message.encoding)?;
            let values = values(&state, names)?;
            rows.extend(values.map(|values| Row {
                logged: message.logged,
                stamp: state.stamp,
                values,
            }));
        }
        Ok(())
    });
    match stop {
        Some(stop) => return Err(stop),
        None => collected?,
    }
    // Containers may hold messages in another order than that in which they came.
    rows.sort_by_key(|row| row.logged);
    Ok(rows)
}

/// Numbers of the wanted columns; None where the message has none of their joints.
fn values(state: &JointState, names: &[&str]) -> Result<Option<Vec<f64>>, String> {
    let mut missing = None;
    let mut found = false;
    let mut values = Vec::with_capacity(names.len());
    for &name in names {
        let Some((channel, joint)) = channel_and_joint(name) else {
            values.push(0.0);
            continue;
        };
        match state.names.iter().position(|other| other == joint) {
            None => missing = Some(joint),
            Some(k) => {
                found = true;
                values.push(state.channels[channel].get(k).copied().unwrap_or(f64::NAN));
            }
        }
    }
    match missing {
        Some(joint) if found => Err(format!(
            "it has some of the joints and not joint {joint}: joints that are sent in different \
             messages have no common samples"
        )),
        Some(_) => Ok(None),
        None => Ok(Some(values)),
    }
}

/// Index of the channel and the joint of a column; None for a time.
fn channel_and_joint(column: &str) -> Option<(usize, &str)> {
    let mut channels = CHANNELS.iter().enumerate();
    channels.find_map(|(c, channel)| {
        let joint = column.strip_prefix(channel)?.strip_prefix('_')?;
        Some((c, joint))
    })
}

/// The error of a message that cannot be used, by its number from 1 among the joint states.
pub(super) fn bad_message(path: &Path, number: usize, reason: String) -> RecordingError {
    let kind = RecordingErrorKind::BadMessage { reason };
    RecordingError::new(Place::file(path).line(number), kind)
}
