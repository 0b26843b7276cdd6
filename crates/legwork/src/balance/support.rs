//! The base of support: the convex hull of the places of contact points, in the plane the piece between its two ends.
//!
//! What is measured against its edges is measured along one direction, the way out of it ([`way_out`]): for a place inside the
//! outward normal of the nearest edge, for a place outside the direction from the nearest point of the polygon. Along it the
//! polygon is a piece with two ends, as in the plane, and the distance to the farther end is the distance to the polygon.

use super::Point;

/// Points closer than this are one, and a point that is less than this outside of an edge is on it [m].
const ONE: f64 = 1e-9;

/// The component of `place` along `way`.
#[inline]
pub fn along(way: Point, place: Point) -> f64 {
    way[0] * place[0] + way[1] * place[1]
}

/// Smallest and largest of places; none where there are none.
pub fn ends(places: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    places.fold(None, |ends, x| Some(ends.map_or([x, x], |[low, high]: [f64; 2]| [low.min(x), high.max(x)])))
}

/// The unit direction in which `place` is nearest to leaving the convex hull of `points`, or has left it; none where the hull is
/// one point and `place` is there. Allocates nothing.
pub fn way_out(points: impl Iterator<Item = Point> + Clone, place: Point) -> Option<Point> {
    let less = |a: Point, b: Point| [a[0] - b[0], a[1] - b[1]];
    let unit = |way: Point| {
        let length = libm::hypot(way[0], way[1]);
        (length > ONE).then(|| (length, way.map(|part| part / length)))
    };
    // By the distance to the nearest point of an edge that it is outside of, else by that to the nearest edge.
    let [mut outside, mut inside]: [Option<(f64, Point)>; 2] = [None; 2];
    for (from, to) in points.clone().flat_map(|from| points.clone().map(move |to| (from, to))) {
        let Some((length, edge)) = unit(less(to, from)) else { continue };
        let normal = [edge[1], -edge[0]];
        if points.clone().any(|other| along(normal, less(other, from)) > ONE) {
            continue;
        }
        let at = less(place, from);
        let beyond = along(normal, at);
        if beyond < 0.0 {
            if inside.is_none_or(|(most, _)| beyond > most) {
                inside = Some((beyond, normal));
            }
            continue;
        }
        let foot = along(edge, at).clamp(0.0, length);
        let (distance, way) = unit(less(at, edge.map(|part| foot * part))).unwrap_or((0.0, normal));
        if outside.is_none_or(|(least, _)| distance < least) {
            outside = Some((distance, way));
        }
    }
    match outside.or(inside) {
        Some((_, way)) => Some(way),
        None => points.clone().next().and_then(|point| unit(less(place, point))).map(|(_, way)| way),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::balance::margin;

    fn distance(points: &[Point], place: Point) -> f64 {
        let way = way_out(points.iter().copied(), place).expect("a way out");
        assert!((along(way, way) - 1.0).abs() < 1e-12);
        let ends = ends(points.iter().map(|&point| along(way, point))).expect("points");
        margin(ends, along(way, place))
    }

    #[test]
    fn margins_are_distances_to_the_nearest_edge_or_corner() {
        // A rectangle with points on its edges and inside of it.
        let feet =
            [[-0.1, -0.2], [0.2, -0.2], [-0.1, -0.1], [0.2, -0.1], [-0.1, 0.1], [0.2, 0.1], [-0.1, 0.2], [0.2, 0.2]];
        let cases = [
            ([0.0, 0.0], 0.1),
            ([0.15, 0.1], 0.05),
            ([0.05, -0.17], 0.03),
            ([0.05, 0.3], -0.1),
            ([-0.3, 0.0], -0.2),
            ([0.5, -0.6], -0.5),
            ([0.2, 0.0], 0.0),
        ];
        for angle in [0.0, 0.3, 1.57, 2.5, -2.0] {
            let (sin, cos) = libm::sincos(angle);
            let turned = |[x, y]: Point| [cos * x - sin * y, sin * x + cos * y];
            for (place, expected) in cases {
                let found = distance(&feet.map(turned), turned(place));
                assert!((found - expected).abs() < 1e-9, "{place:?} turned by {angle}: {found}");
            }
        }
    }

    #[test]
    fn points_on_a_line_and_a_single_one_have_nothing_inside() {
        let line = [[0.0, 0.0], [0.1, 0.1], [0.3, 0.3]];
        for (place, expected) in
            [([0.2, 0.2], 0.0), ([0.3, 0.1], -libm::sqrt(0.02)), ([0.6, 0.7], -0.5), ([0.4, 0.4], -libm::sqrt(0.02))]
        {
            assert!((distance(&line, place) - expected).abs() < 1e-9, "{place:?}: {}", distance(&line, place));
        }
        assert!((distance(&[[0.1, 0.0]], [0.4, 0.4]) + 0.5).abs() < 1e-15);
        assert_eq!(way_out([[0.1, 0.0]].into_iter(), [0.1, 0.0]), None);
        assert_eq!(way_out(std::iter::empty(), [0.1, 0.0]), None);
    }
}
