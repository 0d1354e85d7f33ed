//! Bodies of uniform density from closed meshes, by tetrahedra between the faces and a point.
//!
//! With a face (a, b, c) seen from the point, `V = a·(b × c)/6`, its centre of mass is `(a + b + c)/4` and
//! `∫ x xᵀ dV = V/20 · (a aᵀ + b bᵀ + c cᵀ + s sᵀ)`, s = a + b + c (Tonon 2004). A `shell` has the area A of a face for V,
//! thirds for quarters and `A/12` for `V/20`; `legacy` takes every tetrahedron as positive.

use crate::fault::nearest;
use crate::robot::error::RobotError;
use crate::robot::inertia::{CentralInertia, Inertia};
use crate::robot::mjcf::compiler::Compiler;
use crate::robot::mjcf::document::Id;
use crate::robot::mjcf::messages::fail;
use crate::robot::mjcf::model::Model;
use crate::robot::mjcf::settings::Settings;
use crate::robot::mjcf_fault::MjcfFault;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use std::path::{Path, PathBuf};

/// Largest mesh, bytes.
const SIZE_LIMIT: u64 = 256 << 20;

/// Share of the extent of a mesh by which a vertex may stand out of a convex one.
const CONVEX: f64 = 1e-6;

/// Most faces of a mesh that is looked at for convexity, which takes their square.
const MOST_CONVEX: usize = 20_000;

/// How a mesh is filled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Filling {
    Exact,
    Legacy,
    Convex,
    Shell,
}

/// Triangles, m.
type Faces = Vec<[Vector3<f64>; 3]>;

impl Model<'_> {
    /// The body of density 1 of a mesh, about the origin of its frame.
    pub fn mesh_body(&self, geom: Id, name: &str) -> Result<Inertia, RobotError> {
        let Some(&id) = self.meshes.assets.get(name) else {
            let fault = MjcfFault::UnknownMesh {
                found: name.to_string(),
                nearest: nearest(name, self.meshes.assets.keys().map(String::as_str)),
            };
            return fail(self.document.place(geom), fault);
        };
        let settings = self.classes.settings(self.document, id, None)?;
        let filling = match settings.word("inertia", &["convex", "exact", "legacy", "shell"])? {
            Some("convex") => Filling::Convex,
            Some("exact") => Filling::Exact,
            Some("shell") => Filling::Shell,
            _ => Filling::Legacy,
        };
        let faces = placed(faces(self.compiler, &settings, name)?, &settings)?;
        let mesh = name.to_string();
        if filling == Filling::Convex && !is_convex(&faces) {
            return settings.fail(MjcfFault::MeshNotConvex { mesh });
        }
        match filled(&faces, filling) {
            Some(body) => Ok(body),
            None if volume(&faces) < 0.0 => settings.fail(MjcfFault::MeshNotClosed { mesh }),
            None => settings.fail(MjcfFault::NoVolume { mesh }),
        }
    }
}

/// The faces as they are written.
fn faces(compiler: &Compiler, settings: &Settings<'_>, name: &str) -> Result<Faces, RobotError> {
    let unsupported =
        |what: String, instead| settings.fail(MjcfFault::Unsupported { what, instead });
    if let Some(file) = settings.text("file") {
        let path = path(compiler, file);
        return read(&path).or_else(|reason| {
            let file = path.display().to_string();
            settings.fail(MjcfFault::MeshFile { file, reason })
        });
    }
    if settings.text("builtin").is_some() {
        let what = format!("the inertia of the built-in mesh `{name}`");
        return unsupported(what, "give the body its <inertial>");
    }
    const ANY: usize = 10_000_000;
    let (points, corners) = (
        settings.numbers("vertex", 9..=ANY)?,
        settings.numbers("face", 3..=ANY)?,
    );
    let (Some(points), Some(corners)) = (points, corners) else {
        let what = format!("the inertia of the mesh `{name}`, which has no faces,");
        return unsupported(what, "give its faces, or the body its <inertial>");
    };
    let points: Vec<Vector3<f64>> = points
        .chunks_exact(3)
        .map(Vector3::from_row_slice)
        .collect();
    let triangles = corners.chunks_exact(3).map(|c| {
        let point = |k: usize| points.get(c[k] as usize).copied();
        Some([point(0)?, point(1)?, point(2)?])
    });
    match triangles.collect::<Option<Faces>>() {
        Some(faces) => Ok(faces),
        None => settings.fail(MjcfFault::MeshFile {
            file: name.to_string(),
            reason: "a face has a vertex that does not exist".to_string(),
        }),
    }
}

fn path(compiler: &Compiler, file: &str) -> PathBuf {
    let file = Path::new(file);
    match file.file_name() {
        Some(name) if compiler.strip_path => compiler.mesh_folder.join(name),
        _ => compiler.mesh_folder.join(file),
    }
}

/// The faces of a file, by the end of its name.
fn read(path: &Path) -> Result<Faces, String> {
    let end = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    let end = end.to_ascii_lowercase();
    if !["obj", "stl"].contains(&end.as_str()) {
        return Err(format!("`{end}` is neither obj nor stl"));
    }
    let metadata = std::fs::metadata(path).map_err(|e| e.to_string())?;
    let bytes = metadata.len();
    if !metadata.is_file() || bytes > SIZE_LIMIT {
        return Err(format!(
            "it is no file of at most {SIZE_LIMIT} bytes, but has {bytes}"
        ));
    }
    let content = std::fs::read(path).map_err(|e| e.to_string())?;
    match end.as_str() {
        "obj" => obj(&String::from_utf8_lossy(&content)),
        _ => stl(&content),
    }
}

/// Wavefront OBJ: `v x y z` and `f a b c ...`, with corners `v/vt/vn`, from 1 or from the end.
fn obj(text: &str) -> Result<Faces, String> {
    let mut points: Vec<Vector3<f64>> = Vec::new();
    let mut faces = Faces::new();
    for (line, content) in (1..).zip(text.lines()) {
        let mut words = content.split_whitespace();
        match words.next() {
            Some("v") => {
                let numbers = words.take(3).map(str::parse::<f64>);
                let numbers: Vec<f64> = numbers
                    .collect::<Result<_, _>>()
                    .map_err(|_| format!("line {line} is no vertex"))?;
                if numbers.len() < 3 || numbers.iter().any(|x| !x.is_finite()) {
                    return Err(format!("line {line} is no vertex"));
                }
                points.push(Vector3::from_row_slice(&numbers));
            }
            Some("f") => {
                let corner = |word: &str| {
                    let index: i64 = word.split('/').next()?.parse().ok()?;
                    let index = if index < 0 {
                        points.len() as i64 + index
                    } else {
                        index - 1
                    };
                    points.get(usize::try_from(index).ok()?).copied()
                };
                let corners: Option<Vec<_>> = words.map(corner).collect();
                let corners = corners.filter(|c| c.len() >= 3);
                let corners = corners.ok_or_else(|| format!("line {line} is no face"))?;
                let fans = corners[1..].windows(2);
                faces.extend(fans.map(|pair| [corners[0], pair[0], pair[1]]));
            }
            _ => {}
        }
    }
    Ok(faces)
}

/// Binary STL: 80 bytes, the number of faces, and 50 bytes for each.
fn stl(content: &[u8]) -> Result<Faces, String> {
    const HEADER: usize = 84;
    const FACE: usize = 50;
    let count = content.get(80..HEADER).and_then(|b| b.try_into().ok());
    let count = count
        .map(u32::from_le_bytes)
        .ok_or("it is too short for a binary STL file")?;
    let body = &content[HEADER..];
    if body.len() != FACE * count as usize {
        return Err(format!(
            "its header says {count} faces, and {} bytes follow; text STL is not read",
            body.len()
        ));
    }
    let number =
        |bytes: &[u8]| f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
    let point = |bytes: &[u8]| Vector3::from_fn(|k, _| number(&bytes[4 * k..]));
    let faces: Faces = body
        .chunks_exact(FACE)
        .map(|face| [point(&face[12..]), point(&face[24..]), point(&face[36..])])
        .collect();
    let finite = faces
        .iter()
        .flatten()
        .all(|p| p.iter().all(|x| x.is_finite()));
    finite
        .then_some(faces)
        .ok_or_else(|| "a vertex is not finite".to_string())
}

/// Moved to the reference frame and scaled; a mesh that is mirrored keeps its outside.
fn placed(mut faces: Faces, settings: &Settings<'_>) -> Result<Faces, RobotError> {
    let scale = settings.vector("scale")?.unwrap_or(Vector3::repeat(1.0));
    let origin = settings.vector("refpos")?.unwrap_or_default();
    let turn = match settings.numbers("refquat", 4..=4)? {
        Some(q) => UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3])),
        None => UnitQuaternion::identity(),
    };
    for face in &mut faces {
        for point in face.iter_mut() {
            *point = (turn.inverse() * (*point - origin)).component_mul(&scale);
        }
        if scale.product() < 0.0 {
            face.swap(1, 2);
        }
    }
    Ok(faces)
}

/// Six times the volume of the tetrahedron between a point and a face.
fn sixfold([a, b, c]: &[Vector3<f64>; 3], from: &Vector3<f64>) -> f64 {
    (a - from).dot(&(b - from).cross(&(c - from)))
}

fn volume(faces: &Faces) -> f64 {
    let from = middle(faces);
    faces.iter().map(|face| sixfold(face, &from)).sum::<f64>() / 6.0
}

fn area([a, b, c]: &[Vector3<f64>; 3]) -> f64 {
    0.5 * (b - a).cross(&(c - a)).norm()
}

/// The centre of the surface.
fn middle(faces: &Faces) -> Vector3<f64> {
    let of = |face: &[Vector3<f64>; 3]| (face[0] + face[1] + face[2]) * (area(face) / 3.0);
    let sum: Vector3<f64> = faces.iter().map(of).sum();
    let total: f64 = faces.iter().map(area).sum();
    if total > 0.0 { sum / total } else { sum }
}

/// The body of density 1; `None` where its volume (its area, for a shell) is not positive.
fn filled(faces: &Faces, filling: Filling) -> Option<Inertia> {
    let from = middle(faces);
    let (mut mass, mut first) = (0.0, Vector3::zeros());
    for face in faces {
        let (part, centre) = match filling {
            Filling::Shell => (area(face), (face[0] + face[1] + face[2]) / 3.0),
            _ => (
                tetrahedron(face, &from, filling),
                (face[0] + face[1] + face[2] + from) / 4.0,
            ),
        };
        mass += part;
        first += part * centre;
    }
    // Faces that look inwards make negative volumes.
    if mass.is_nan() || mass <= f64::MIN_POSITIVE {
        return None;
    }
    let centre = first / mass;
    let (mut total, mut second) = (0.0, Matrix3::zeros());
    for face in faces {
        let [a, b, c] = face.map(|point| point - centre);
        let sum = a + b + c;
        let squares = a * a.transpose() + b * b.transpose() + c * c.transpose();
        let (part, share) = match filling {
            Filling::Shell => (area(face), 12.0),
            _ => (tetrahedron(face, &centre, filling), 20.0),
        };
        total += part;
        second += (squares + sum * sum.transpose()) * (part / share);
    }
    let tensor = Matrix3::identity() * second.trace() - second;
    Some(Inertia::from_central(&CentralInertia {
        mass: total,
        centre,
        tensor,
    }))
}

fn tetrahedron(face: &[Vector3<f64>; 3], from: &Vector3<f64>, filling: Filling) -> f64 {
    let volume = sixfold(face, from) / 6.0;
    match filling {
        Filling::Legacy => volume.abs(),
        _ => volume,
    }
}

/// Whether no vertex stands before the plane of a face. Of more faces than [`MOST_CONVEX`] it is not told.
fn is_convex(faces: &Faces) -> bool {
    if faces.len() > MOST_CONVEX {
        return false;
    }
    let from = middle(faces);
    let points = || faces.iter().flatten();
    let extent = points().map(|p| (p - from).norm()).fold(0.0, f64::max);
    faces.iter().all(|[a, b, c]| {
        let normal = (b - a).cross(&(c - a));
        let reach = normal.norm() * CONVEX * extent;
        points().all(|p| normal.dot(&(p - a)) <= reach)
    })
}
