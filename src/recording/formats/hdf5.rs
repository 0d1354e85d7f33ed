//! HDF5 files, and MATLAB files of version 7.3, which are such: numeric datasets of one or two sides by their names; those
//! of a group, as fields of a structure, are named `group.dataset`.

use std::borrow::Cow;
use std::path::Path;

use hdf5_reader::{ByteOrder as Order, Dataset, Datatype, Hdf5File, OpenOptions};

use crate::fault::Place;
use crate::recording::error::{RecordingError, RecordingErrorKind};
use crate::recording::formats::arrays::{Layout, Storage, assemble, column_names};
use crate::recording::formats::number_type::{ByteOrder, NumberType};
use crate::recording::formats::reading::Reading;
use crate::recording::formats::reading::from_io;
use crate::recording::formats::table::Table;

/// Groups in groups that are followed; deeper ones hold no recording.
const DEEPEST: usize = 8;

/// Most datasets that are looked at: files of a simulator hold thousands, those that take minutes to list are none.
const MOST_DATASETS: usize = 100_000;

/// Column names of a file.
pub fn columns(path: &Path, reading: &Reading) -> Result<Vec<String>, RecordingError> {
    let layouts: Vec<Layout> = list(path, reading)?.into_iter().map(|a| a.layout).collect();
    Ok(column_names(&layouts))
}

/// The wanted columns of a file.
pub fn read(path: &Path, wanted: &[String], reading: &Reading) -> Result<Table, RecordingError> {
    let arrays = list(path, reading)?;
    let layouts: Vec<Layout> = arrays.iter().map(|array| array.layout.clone()).collect();
    assemble(path, &layouts, wanted, |at| {
        let Array {
            dataset,
            number,
            order,
            ..
        } = &arrays[at];
        reading.goes_on(path)?;
        let bytes = dataset.read_raw_bytes();
        let bytes = bytes.map_err(|error| corrupt(path, error.to_string()))?;
        Ok(Cow::Owned(number.decode(&bytes, *order)))
    })
}

/// A dataset that can hold channels.
struct Array {
    layout: Layout,
    dataset: Dataset,
    number: NumberType,
    order: ByteOrder,
}

fn corrupt(path: &Path, reason: String) -> RecordingError {
    let kind = RecordingErrorKind::Corrupt {
        format: "HDF5 file",
        reason: reason.into(),
    };
    RecordingError::new(Place::file(path), kind)
}

fn list(path: &Path, reading: &Reading) -> Result<Vec<Array>, RecordingError> {
    let bytes = reading.whole_file(path)?;
    if bytes.is_empty() {
        let kind = RecordingErrorKind::EmptyFile;
        return Err(RecordingError::new(Place::file(path), kind));
    }
    let options = OpenOptions::default().with_max_read_bytes(reading.most_bytes());
    let length = bytes.len() as u64;
    let file = Hdf5File::from_vec_with_options(bytes, options);
    let file = file.map_err(|error| corrupt(path, error.to_string()))?;
    // What was cut off may be no channel, but nothing says so.
    let expected = file.superblock().eof_address;
    if length < expected {
        let reason = format!("it ends after {length} of {expected} bytes");
        return Err(corrupt(path, reason));
    }
    let root = file.root_group();
    let root = root.map_err(|error| corrupt(path, error.to_string()))?;
    let mut arrays = Vec::new();
    let mut groups = vec![(String::new(), root, 0)];
    let mut looked_at = 0;
    while let Some((prefix, group, depth)) = groups.pop() {
        reading.goes_on(path)?;
        let members = group.members();
        let (inner, datasets) = members.map_err(|error| corrupt(path, error.to_string()))?;
        looked_at += datasets.len() + inner.len();
        if looked_at > MOST_DATASETS {
            return Err(corrupt(
                path,
                format!("it has more than {MOST_DATASETS} datasets"),
            ));
        }
        arrays.extend(datasets.into_iter().filter_map(|set| array(&prefix, set)));
        // MATLAB keeps the contents of cells and objects under names of its own.
        let own = |name: &str| depth == 0 && name.starts_with('#');
        for group in inner {
            if depth < DEEPEST && !own(group.name()) {
                groups.push((format!("{prefix}{}.", group.name()), group, depth + 1));
            }
        }
    }
    Ok(arrays)
}

/// A numeric dataset as an array; None of others.
fn array(prefix: &str, dataset: Dataset) -> Option<Array> {
    let (number, order) = match dataset.dtype() {
        Datatype::FixedPoint {
            size,
            signed,
            byte_order,
        } => {
            let number = match (size, signed) {
                (1, true) => NumberType::I8,
                (1, false) => NumberType::U8,
                (2, true) => NumberType::I16,
                (2, false) => NumberType::U16,
                (4, true) => NumberType::I32,
                (4, false) => NumberType::U32,
                (8, true) => NumberType::I64,
                (8, false) => NumberType::U64,
                _ => return None,
            };
            (number, byte_order)
        }
        Datatype::FloatingPoint { size, byte_order } => match size {
            4 => (NumberType::F32, byte_order),
            8 => (NumberType::F64, byte_order),
            _ => return None,
        },
        _ => return None,
    };
    let order = match order {
        Order::LittleEndian => ByteOrder::Little,
        Order::BigEndian => ByteOrder::Big,
    };
    let sides: Option<Vec<usize>> = (dataset.shape().iter())
        .map(|side| usize::try_from(*side).ok())
        .collect();
    let name = format!("{prefix}{}", dataset.name().trim_start_matches('/'));
    let layout = Layout::new(&name, &sides?, Storage::RowMajor)?;
    Some(Array {
        layout,
        dataset,
        number,
        order,
    })
}

/// Whether a file is HDF5, behind the text that MATLAB puts before it or not.
pub(super) fn is_hdf5(path: &Path) -> Result<bool, RecordingError> {
    use std::io::Read;
    let file = std::fs::File::open(path).map_err(|error| from_io(Place::file(path), &error))?;
    let mut head = Vec::new();
    let read = file.take(16).read_to_end(&mut head);
    read.map_err(|error| from_io(Place::file(path), &error))?;
    Ok(head.starts_with(b"MATLAB 7.3") || head.starts_with(b"\x89HDF"))
}
