//! Files of triangles, STL, OBJ and MSH, and the volume that they enclose with its moments.

use std::collections::HashMap;

use nalgebra::{Matrix3, Vector3};

use super::bodies::then;
use super::collada;
use super::compiler::Compiler;
use super::defaults::{Defaults, Item};
use super::files::{ReadFile, Tree};
use crate::error::ModelError;
use crate::joints::rotation_from_quaternion;
use crate::spatial::Placement;
use crate::words::{list, quoted};

/// What encloses a volume: its triangles.
type Triangles = Vec<[Vector3<f64>; 3]>;

/// Of a body with density 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Volume {
    /// [m³]
    pub(super) volume: f64,
    pub(super) centre: Vector3<f64>,
    /// About the centre [m⁵].
    pub(super) inertia: Matrix3<f64>,
}

/// The meshes of `<asset>`. A file is read when its volume is asked for.
pub(super) struct Meshes<'a, 'b> {
    by_name: HashMap<String, Item<'a>>,
    volumes: HashMap<String, Volume>,
    compiler: &'b Compiler,
    read: ReadFile<'b>,
}

impl<'a, 'b> Meshes<'a, 'b> {
    pub(super) fn new(
        tree: &Tree<'a>,
        defaults: &Defaults<'a>,
        compiler: &'b Compiler,
        read: ReadFile<'b>,
    ) -> Result<Self, ModelError> {
        let mut by_name = HashMap::new();
        for asset in tree.sections("asset") {
            for element in tree.children(asset).into_iter().filter(|child| child.name() == "mesh") {
                let file = element.get("file").unwrap_or_default();
                let base = file.rsplit(['/', '\\']).next().unwrap_or(file);
                let stem = base.rsplit_once('.').map_or(base, |(stem, _)| stem);
                let name = element.get("name").unwrap_or(stem);
                by_name.insert(name.to_owned(), defaults.item(element.of("mesh"), 0)?);
            }
        }
        Ok(Self { by_name, volumes: HashMap::new(), compiler, read })
    }

    fn item(&self, name: &str, at: &Item) -> Result<&Item<'a>, ModelError> {
        self.by_name.get(name).ok_or_else(|| {
            let mut names: Vec<_> = self.by_name.keys().collect();
            names.sort();
            at.element().invalid(format!("unknown mesh {}; valid are {}", quoted(name), list(names)))
        })
    }

    /// The file and scale of a mesh.
    pub(super) fn file(&self, name: &str, at: &Item) -> Result<(String, Vector3<f64>), ModelError> {
        let item = self.item(name, at)?;
        let scale = Vector3::from(item.row("scale")?.unwrap_or([1.0; 3]));
        Ok((item.element().get("file").map_or_else(String::new, |file| self.compiler.mesh_path(file)), scale))
    }

    /// The volume of a mesh, in the frame of its shape.
    pub(super) fn volume(&mut self, name: &str, at: &Item) -> Result<Volume, ModelError> {
        if let Some(volume) = self.volumes.get(name) {
            return Ok(*volume);
        }
        let volume = self.measured(self.item(name, at)?)?;
        self.volumes.insert(name.to_owned(), volume);
        Ok(volume)
    }

    fn measured(&self, item: &Item) -> Result<Volume, ModelError> {
        let element = item.element();
        let is_exact = match item.text("inertia").unwrap_or("legacy") {
            "legacy" => false,
            "exact" => true,
            _ => return Err(element.invalid("mesh inertia: valid are legacy and exact; give the bodies an <inertial>")),
        };
        let mut triangles = self.triangles(item)?;
        let (refpos, quat) = (Vector3::from(item.row("refpos")?.unwrap_or_default()), item.row::<4>("refquat")?);
        let turned = rotation_from_quaternion(&quat.unwrap_or([1.0, 0.0, 0.0, 0.0])).transpose();
        let scale = Vector3::from(item.row("scale")?.unwrap_or([1.0; 3]));
        for triangle in &mut triangles {
            *triangle = triangle.map(|corner| (turned * (corner - refpos)).component_mul(&scale));
            if scale.product() < 0.0 {
                triangle.swap(1, 2);
            }
        }
        enclosed(&triangles, is_exact).ok_or_else(|| {
            let problem = "the mesh encloses no volume, or its triangles face inward; give the bodies an <inertial>";
            element.invalid(problem)
        })
    }

    fn triangles(&self, item: &Item) -> Result<Triangles, ModelError> {
        let element = item.element();
        let Some(file) = element.get("file") else { return written_out(item) };
        let path = self.compiler.mesh_path(file);
        let bytes =
            (self.read)(&path).map_err(|unread| element.invalid(format!("file {}: {unread}", quoted(&path))))?;
        let read = of_file(file, &bytes).unwrap_or_else(|| {
            Err("valid for a volume are .stl, .obj and .msh; give the bodies an <inertial>".to_owned())
        });
        read.map_err(|problem| element.invalid(format!("file {}: {problem}", quoted(&path))))
    }
}

/// The triangles of a mesh in a format that its name tells; none of another.
fn of_file(name: &str, bytes: &[u8]) -> Option<Result<Triangles, String>> {
    let reader = match name.rsplit_once('.')?.1.to_ascii_lowercase().as_str() {
        "stl" => stl,
        "obj" => obj,
        "msh" => msh,
        _ => return None,
    };
    Some(reader(bytes))
}

/// The corners of the triangles of a mesh [m], from the `bytes` of the file `name`: STL, OBJ, Collada or MuJoCo's MSH.
///
/// # Errors
/// The file is damaged, or of another format.
pub fn mesh_corners(name: &str, bytes: &[u8]) -> Result<Vec<Vector3<f64>>, String> {
    if name.to_ascii_lowercase().ends_with(".dae") {
        return collada::corners(bytes);
    }
    let read = of_file(name, bytes).ok_or("valid are .stl, .obj, .dae and .msh")??;
    Ok(read.into_iter().flatten().collect())
}

/// The corners and faces of a mesh without a file.
fn written_out(item: &Item) -> Result<Triangles, ModelError> {
    let element = item.element();
    let needed = "a mesh without a file needs vertex and face, numbers with blanks between them; or give the bodies an <inertial>";
    let numbers = |key: &str| -> Option<Vec<f32>> {
        let numbers: Result<_, _> = element.get(key)?.split_whitespace().map(str::parse).collect();
        numbers.ok()
    };
    let (Some(vertices), Some(faces)) = (numbers("vertex"), numbers("face")) else {
        return Err(element.invalid(needed));
    };
    let corners: Vec<_> = vertices.chunks_exact(3).map(corner).collect();
    let triangle = |face: &[f32]| {
        Some([corner_of(&corners, face[0])?, corner_of(&corners, face[1])?, corner_of(&corners, face[2])?])
    };
    let triangles: Option<Triangles> = faces.chunks_exact(3).map(triangle).collect();
    triangles.ok_or_else(|| element.invalid("face names a vertex that there is not"))
}

fn corner(numbers: &[f32]) -> Vector3<f64> {
    Vector3::new(f64::from(numbers[0]), f64::from(numbers[1]), f64::from(numbers[2]))
}

fn corner_of(corners: &[Vector3<f64>], index: f32) -> Option<Vector3<f64>> {
    // Truncated and saturated: what is no index finds nothing or is caught here.
    (index >= 0.0).then(|| corners.get(index as usize).copied()).flatten()
}

/// Triangles of an STL file, binary or as text.
fn stl(bytes: &[u8]) -> Result<Triangles, String> {
    let count = bytes.get(80..84).map(|count| u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize);
    let is_binary = count.is_some_and(|count| bytes.len() >= 84 + 50 * count) && !is_text_stl(bytes, count);
    if is_binary {
        let number = |at: &[u8]| f32::from_le_bytes([at[0], at[1], at[2], at[3]]);
        let triangle = |facet: &[u8]| {
            // Behind the normal.
            let numbers: Vec<f32> = facet[12..48].chunks_exact(4).map(number).collect();
            finite([corner(&numbers[..3]), corner(&numbers[3..6]), corner(&numbers[6..])])
        };
        return bytes[84..].chunks_exact(50).take(count.unwrap_or(0)).map(triangle).collect();
    }
    let text = std::str::from_utf8(bytes).map_err(|_| "is no STL file".to_owned())?;
    if !text.trim_start().starts_with("solid") {
        return Err("is no STL file".to_owned());
    }
    let mut corners = Vec::new();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        if words.next() == Some("vertex") {
            corners.push(three(words)?);
        }
    }
    corners.chunks_exact(3).map(|corners| finite([corners[0], corners[1], corners[2]])).collect()
}

/// Whether an STL file is text though its length would do for a binary one.
fn is_text_stl(bytes: &[u8], count: Option<usize>) -> bool {
    bytes.starts_with(b"solid") && count.is_none_or(|count| bytes.len() != 84 + 50 * count) && bytes.is_ascii()
}

/// Triangles of an OBJ file. Faces of more corners are fans.
fn obj(bytes: &[u8]) -> Result<Triangles, String> {
    let text = String::from_utf8_lossy(bytes);
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for (index, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => corners.push(three(words)?),
            Some("f") => {
                let of = |word: &str| -> Option<Vector3<f64>> {
                    let number: i64 = word.split('/').next()?.parse().ok()?;
                    let index = if number > 0 { number - 1 } else { i64::try_from(corners.len()).ok()? + number };
                    corners.get(usize::try_from(index).ok()?).copied()
                };
                let face: Option<Vec<_>> = words.map(of).collect();
                let face =
                    face.ok_or_else(|| format!("line {}: a face names a corner that there is not", index + 1))?;
                for pair in face.get(1..).unwrap_or_default().windows(2) {
                    triangles.push(finite([face[0], pair[0], pair[1]])?);
                }
            }
            _ => {}
        }
    }
    Ok(triangles)
}

/// Triangles of an MSH file, MuJoCo's own: numbers of vertices, normals, places in a picture and faces; then each of them.
fn msh(bytes: &[u8]) -> Result<Triangles, String> {
    let words: Vec<[u8; 4]> = bytes.chunks_exact(4).map(|word| [word[0], word[1], word[2], word[3]]).collect();
    let short = || "is no MSH file, or ends too early".to_owned();
    let whole = |index: usize| words.get(index).map(|word| i32::from_le_bytes(*word)).ok_or_else(short);
    let count = |index| usize::try_from(whole(index)?).ok().filter(|count| *count < words.len()).ok_or_else(short);
    let [vertices, normals, places, faces] = [count(0)?, count(1)?, count(2)?, count(3)?];
    let numbers: Vec<f32> = words.iter().skip(4).take(3 * vertices).map(|word| f32::from_le_bytes(*word)).collect();
    let corners: Vec<_> = numbers.chunks_exact(3).map(corner).collect();
    let first = 4 + 3 * vertices + 3 * normals + 2 * places;
    let of = |index: usize| {
        let found = usize::try_from(whole(index)?).ok().and_then(|index| corners.get(index).copied());
        found.ok_or_else(|| "a face names a corner that there is not".to_owned())
    };
    let triangle = |face: usize| {
        let at = first + 3 * face;
        finite([of(at)?, of(at + 1)?, of(at + 2)?])
    };
    (0..faces).map(triangle).collect()
}

fn three<'a>(words: impl Iterator<Item = &'a str>) -> Result<Vector3<f64>, String> {
    let numbers: Result<Vec<f32>, _> = words.take(3).map(str::parse).collect();
    let numbers = numbers.ok().filter(|numbers| numbers.len() == 3);
    numbers.map(|numbers| corner(&numbers)).ok_or_else(|| "a corner is not three numbers".to_owned())
}

fn finite(triangle: [Vector3<f64>; 3]) -> Result<[Vector3<f64>; 3], String> {
    let is_finite = triangle.iter().all(|corner| corner.iter().all(|number| number.is_finite()));
    if is_finite { Ok(triangle) } else { Err("a corner is not finite".to_owned()) }
}

/// The volume that triangles enclose, as the sum of pyramids. Unless it is to be `exact`, which asks for triangles that all face
/// outward, every pyramid counts as positive, as MuJoCo does by default: that is the volume of a convex mesh, however its
/// triangles face, and more than that of another. The top of the pyramids is first the triangles' centre, then the centre of mass.
fn enclosed(triangles: &[[Vector3<f64>; 3]], is_exact: bool) -> Option<Volume> {
    let pyramid = |[a, b, c]: &[Vector3<f64>; 3], top: &Vector3<f64>| {
        let volume = (a - top).dot(&(b - top).cross(&(c - top))) / 6.0;
        if is_exact { volume } else { volume.abs() }
    };
    let middle = |[a, b, c]: &[Vector3<f64>; 3]| (a + b + c) / 3.0;
    let (mut area, mut moment) = (0.0, Vector3::zeros());
    for triangle in triangles {
        let [a, b, c] = triangle;
        let part = libm::sqrt((b - a).cross(&(c - a)).norm_squared()) / 2.0;
        (area, moment) = (area + part, moment + middle(triangle) * part);
    }
    let top = positive(area).map(|area| moment / area)?;
    let (mut volume, mut moment) = (0.0, Vector3::zeros());
    for triangle in triangles {
        let part = pyramid(triangle, &top);
        (volume, moment) = (volume + part, moment + (middle(triangle) * 0.75 + top * 0.25) * part);
    }
    let centre = positive(volume).map(|volume| moment / volume)?;
    let (mut volume, mut second) = (0.0, Matrix3::zeros());
    for triangle in triangles {
        let part = pyramid(triangle, &centre);
        let corners = triangle.map(|corner| corner - centre);
        let sum = corners[0] + corners[1] + corners[2];
        // Second moments of a tetrahedron with one corner at the origin: V/20 (Σ x xᵀ + s sᵀ), s = Σ x.
        let products = corners.iter().fold(sum * sum.transpose(), |products, x| products + x * x.transpose());
        (volume, second) = (volume + part, second + products * (part / 20.0));
    }
    let volume = positive(volume)?;
    let inertia = Matrix3::identity() * second.trace() - second;
    Some(Volume { volume, centre, inertia })
}

/// What is enough to divide by.
fn positive(value: f64) -> Option<f64> {
    (value > 1e-15 && value.is_finite()).then_some(value)
}

/// A volume at a placement: its centre and inertia there.
pub(super) fn placed(volume: &Volume, placement: &Placement) -> (Vector3<f64>, Matrix3<f64>) {
    let at = Placement { rotation: Matrix3::identity(), translation: volume.centre };
    let rotation = &placement.rotation;
    (then(placement, &at).translation, rotation * volume.inertia * rotation.transpose())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A brick between the origin and (1, 2, 3), as OBJ with faces of four corners.
    const BRICK: &str = "v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nv 0 0 3\nv 1 0 3\nv 1 2 3\nv 0 2 3\n\
        f 4 3 2 1\nf 5 6 7 8\nf 1/1/1 2/2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf -5 -8 -4 -1\n";

    fn close(found: &[f64], expected: &[f64]) {
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-13 * expected.abs().max(1.0), "{found} {expected}");
        }
    }

    #[test]
    fn a_brick_in_closed_form_from_every_format() {
        let triangles = obj(BRICK.as_bytes()).unwrap();
        assert_eq!(triangles.len(), 12);
        let mut binary = vec![b'x'; 80];
        binary.extend(12_u32.to_le_bytes());
        let mut text = "solid brick\n".to_owned();
        for triangle in &triangles {
            binary.extend([0; 12]);
            text += "facet normal 0 0 0\nouter loop\n";
            for corner in triangle {
                corner.iter().for_each(|number| binary.extend((*number as f32).to_le_bytes()));
                text += &format!("vertex {} {} {:e}\n", corner.x, corner.y, corner.z);
            }
            binary.extend([0; 2]);
            text += "endloop\nendfacet\n";
        }
        text += "endsolid\n";
        let mut own: Vec<u8> = [36_i32, 0, 0, 12].into_iter().flat_map(i32::to_le_bytes).collect();
        let numbers = triangles.iter().flatten().flat_map(|corner| corner.iter());
        own.extend(numbers.flat_map(|number| (*number as f32).to_le_bytes()));
        own.extend((0..36_i32).flat_map(i32::to_le_bytes));
        let others = [stl(&binary).unwrap(), stl(text.as_bytes()).unwrap(), msh(&own).unwrap()];
        for triangles in others.into_iter().chain([triangles.clone()]) {
            for is_exact in [false, true] {
                let Volume { volume, centre, inertia } = enclosed(&triangles, is_exact).unwrap();
                close(&[volume], &[6.0]);
                close(centre.as_slice(), &[0.5, 1.0, 1.5]);
                close(inertia.as_slice(), &[6.5, 0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 2.5]);
            }
        }
        let inward: Vec<_> = triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
        assert!(enclosed(&inward, true).is_none());
        close(&[enclosed(&inward, false).unwrap().volume], &[6.0]);
        assert!(enclosed(&[], false).is_none());
    }

    #[test]
    fn what_is_no_mesh_is_refused() {
        for bytes in [&b""[..], b"solid\nvertex 1 2\n", b"solid\nvertex 1 2 x\n", b"\xff\xfe\xfd", b"PK"] {
            assert!(stl(bytes).is_err(), "{bytes:?}");
        }
        for bytes in [&b""[..], &[1; 16], &[0xff; 16], &[9, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0]] {
            assert!(msh(bytes).is_err(), "{bytes:?}");
        }
        for text in ["v 1 2", "v 1 2 3\nf 1 2 3", "f 0 0 0", "v 0 0 0\nf -9 1 1", "v 1e99 0 0\nf 1 1 1"] {
            assert!(obj(text.as_bytes()).is_err(), "{text}");
        }
    }
}
