//! The corners of a Collada file's meshes, where its scene has them. Its axes are taken as the link's, as robots' tools do, whatever the
//! file says of the axis that is up.

use nalgebra::{Matrix4, Rotation3, Unit, Vector3, Vector4};
use roxmltree::{Document, Node};

/// The corners [m].
pub(super) fn corners(bytes: &[u8]) -> Result<Vec<Vector3<f64>>, String> {
    let text = String::from_utf8_lossy(bytes);
    let document = Document::parse(&text).map_err(|error| format!("cannot be read as Collada: {error}"))?;
    let named = |name: &'static str| {
        document.descendants().filter(move |node| node.has_tag_name((node.tag_name().namespace().unwrap_or(""), name)))
    };
    let meter = named("unit").find_map(|unit| unit.attribute("meter")?.parse::<f64>().ok()).unwrap_or(1.0);
    let mut corners = Vec::new();
    for instance in named("instance_geometry") {
        let url = instance.attribute("url").unwrap_or_default().trim_start_matches('#');
        let Some(geometry) = named("geometry").find(|geometry| geometry.attribute("id") == Some(url)) else { continue };
        let pose = instance
            .ancestors()
            .filter(|node| node.tag_name().name() == "node")
            .try_fold(Matrix4::identity(), |inner, node| Ok::<_, String>(placement(node)? * inner))?;
        for position in positions(geometry)? {
            let placed = pose * Vector4::new(position.x, position.y, position.z, 1.0);
            corners.push(placed.xyz() * meter);
        }
    }
    if corners.iter().any(|corner| corner.iter().any(|number| !number.is_finite())) {
        return Err("a corner is not finite".to_owned());
    }
    Ok(corners)
}

/// The product of a node's transformations, in the order of the file.
fn placement(node: Node) -> Result<Matrix4<f64>, String> {
    let mut pose = Matrix4::identity();
    for child in node.children().filter(Node::is_element) {
        let next = match child.tag_name().name() {
            "matrix" => Matrix4::from_row_slice(&numbers::<16>(child)?),
            "translate" => Matrix4::new_translation(&Vector3::from(numbers::<3>(child)?)),
            "scale" => Matrix4::new_nonuniform_scaling(&Vector3::from(numbers::<3>(child)?)),
            "rotate" => {
                let [x, y, z, degrees] = numbers::<4>(child)?;
                let axis = Vector3::new(x, y, z);
                if axis.norm_squared() == 0.0 {
                    continue;
                }
                let (sin, cos) = libm::sincos(degrees.to_radians());
                let axis = Unit::new_normalize(axis);
                let (outer, cross) = (axis.as_ref() * axis.transpose(), axis.cross_matrix());
                let rotation = nalgebra::Matrix3::identity() * cos + cross * sin + outer * (1.0 - cos);
                Rotation3::from_matrix_unchecked(rotation).to_homogeneous()
            }
            _ => continue,
        };
        pose *= next;
    }
    Ok(pose)
}

/// The positions of a geometry's vertices.
fn positions(geometry: Node) -> Result<Vec<Vector3<f64>>, String> {
    let is_positions =
        |input: &Node| input.tag_name().name() == "input" && input.attribute("semantic") == Some("POSITION");
    let Some(input) = geometry.descendants().find(is_positions) else { return Ok(Vec::new()) };
    let id = input.attribute("source").unwrap_or_default().trim_start_matches('#');
    let source = geometry.descendants().find(|node| node.attribute("id") == Some(id));
    let array = source.and_then(|source| source.children().find(|child| child.tag_name().name() == "float_array"));
    let text = array.and_then(|array| array.text()).unwrap_or_default();
    let numbers: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
    let numbers = numbers.map_err(|_| "a corner is not three numbers".to_owned())?;
    Ok(numbers.chunks_exact(3).map(Vector3::from_column_slice).collect())
}

fn numbers<const N: usize>(element: Node) -> Result<[f64; N], String> {
    let numbers: Result<Vec<f64>, _> = element.text().unwrap_or_default().split_whitespace().map(str::parse).collect();
    let numbers = numbers.ok().and_then(|numbers| <[f64; N]>::try_from(numbers).ok());
    numbers.ok_or_else(|| format!("<{}> is not {N} numbers", element.tag_name().name()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_are_where_the_scene_has_them() {
        let file = r##"<?xml version="1.0"?>
            <COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit meter="0.01"/></asset>
            <library_geometries><geometry id="g"><mesh>
              <source id="p"><float_array id="a" count="6">1 2 3  4 0 0</float_array></source>
              <source id="n"><float_array id="b" count="3">9 9 9</float_array></source>
              <vertices id="v"><input semantic="POSITION" source="#p"/></vertices></mesh></geometry></library_geometries>
            <library_visual_scenes><visual_scene><node><translate>10 0 0</translate>
              <node><rotate>0 0 1 90</rotate><scale>2 1 1</scale><instance_geometry url="#g"/></node></node></visual_scene>
            </library_visual_scenes></COLLADA>"##;
        let found = corners(file.as_bytes()).expect("a mesh");
        // Scaled to (2, 2, 3) and (8, 0, 0), turned to (-2, 2, 3) and (0, 8, 0), moved, in centimetres.
        let expected = [Vector3::new(0.08, 0.02, 0.03), Vector3::new(0.10, 0.08, 0.0)];
        assert_eq!(found.len(), 2);
        assert!(found.iter().zip(&expected).all(|(found, expected)| (found - expected).amax() < 1e-15), "{found:?}");
        assert!(corners(b"<a>").is_err());
        assert!(corners(file.replace("2 1 1", "2 1").as_bytes()).is_err());
    }
}
