//! The thinning of long lines to what a screen can show.

/// How far a thinned line may be from the full one [px].
const TOLERANCE: f64 = 0.2;

/// Thins a line whose points come from left to right [px]: of each column of pixels its lowest and highest point, of
/// those what a straight line would miss. Where a point is not finite the line is broken.
pub(super) fn thin(points: impl IntoIterator<Item = [f64; 2]>) -> Vec<Vec<[f64; 2]>> {
    let mut lines = vec![Vec::new()];
    for point in points {
        if point.iter().all(|value| value.is_finite()) {
            lines.last_mut().expect("there is always a line").push(point);
        } else {
            lines.push(Vec::new());
        }
    }
    lines.iter().filter(|line| !line.is_empty()).map(|line| straighten(&columns(line))).collect()
}

/// First and last point of a line, and the lowest and highest of each column of pixels.
fn columns(line: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut kept = vec![0];
    let mut start = 0;
    for column in line.chunk_by(|a, b| a[0].floor().total_cmp(&b[0].floor()).is_eq()) {
        let place = |index: usize| (column[index][1], index);
        let lowest = (0..column.len()).map(place).fold(place(0), |a, b| if b.0 < a.0 { b } else { a }).1;
        let highest = (0..column.len()).map(place).fold(place(0), |a, b| if b.0 > a.0 { b } else { a }).1;
        kept.extend([start + lowest.min(highest), start + lowest.max(highest)]);
        start += column.len();
    }
    kept.push(line.len() - 1);
    kept.dedup();
    kept.into_iter().map(|index| line[index]).collect()
}

/// Leaves out points that lie within [`TOLERANCE`] of the line between the ones that stay.
fn straighten(line: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut kept = vec![0];
    let mut anchor = 0;
    // Slopes from the anchor that miss no point since then.
    let (mut shallow, mut steep) = (f64::NEG_INFINITY, f64::INFINITY);
    for (index, [x, y]) in line.iter().enumerate().skip(1) {
        let slope = |anchor: usize, y: f64| (y - line[anchor][1]) / (x - line[anchor][0]);
        let straight = *x > line[anchor][0] && (shallow..=steep).contains(&slope(anchor, *y));
        if !straight && index - 1 > anchor {
            anchor = index - 1;
            kept.push(anchor);
            (shallow, steep) = (f64::NEG_INFINITY, f64::INFINITY);
        }
        if *x > line[anchor][0] {
            shallow = shallow.max(slope(anchor, y - TOLERANCE));
            steep = steep.min(slope(anchor, y + TOLERANCE));
        } else {
            anchor = index;
            kept.push(anchor);
        }
    }
    kept.push(line.len() - 1);
    kept.dedup();
    kept.into_iter().map(|index| line[index]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thinned_line_keeps_ends_and_peaks_and_stays_close() {
        // It rises by less than a pixel a pixel, save for one peak.
        let wave = |k: usize| [k as f64 * 0.05, 20.0 * (k as f64 * 0.002).sin() + if k == 4321 { 500.0 } else { 0.0 }];
        let lines = thin((0..10_000).map(wave));
        assert_eq!(lines.len(), 1);
        let line = &lines[0];
        assert!(line.len() < 100, "{}", line.len());
        assert_eq!((line[0], line[line.len() - 1]), (wave(0), wave(9999)));
        assert!(line.contains(&wave(4321)));
        for k in (0..4300).chain(4340..10_000) {
            let [x, y] = wave(k);
            let right = line.iter().position(|point| point[0] >= x).expect("it reaches to the end");
            let [a, b] = [line[right.saturating_sub(1)], line[right]];
            let share = if b[0] > a[0] { (x - a[0]) / (b[0] - a[0]) } else { 0.0 };
            assert!((y - a[1] - share * (b[1] - a[1])).abs() < 1.0, "{k}");
        }
    }

    #[test]
    fn a_straight_line_needs_two_points_and_a_gap_breaks_it() {
        assert_eq!(thin((0..1000).map(|k| [f64::from(k), 2.0 * f64::from(k)]))[0].len(), 2);
        let gap = |k: i32| [f64::from(k), if k == 5 { f64::NAN } else { 1.0 }];
        assert_eq!(thin((0..10).map(gap)).len(), 2);
        assert!(thin([]).is_empty());
        assert_eq!(thin([[1.0, 2.0]]), [[[1.0, 2.0]]]);
    }
}
