//! Recorded programs; the format is described in `tests/data/README.md`.

use legwork_qp::Problem;

/// All programs of a recording, in order.
pub fn decode(mut bytes: &[u8]) -> Vec<Problem> {
    let mut size = || u32::from_le_bytes(*take(&mut bytes)) as usize;
    let (n, m, count) = (size(), size(), size());
    let length = n * n + n + m * n + 2 * m + 2 * n;
    let mut numbers = vec![0.0; length];
    let mut programs = Vec::with_capacity(count);
    for _ in 0..count {
        let (changed, rest) = bytes.split_at(length.div_ceil(8));
        bytes = rest;
        for (k, number) in numbers.iter_mut().enumerate() {
            if changed[k / 8] >> (k % 8) & 1 == 1 {
                *number = f64::from_le_bytes(*take(&mut bytes));
            }
        }
        programs.push(program(n, m, &numbers));
    }
    assert!(bytes.is_empty());
    programs
}

fn take<'a, const N: usize>(bytes: &mut &'a [u8]) -> &'a [u8; N] {
    let (first, rest) = bytes.split_first_chunk().unwrap();
    *bytes = rest;
    first
}

fn program(n: usize, m: usize, numbers: &[f64]) -> Problem {
    let mut p = Problem::new(n, m);
    let mut numbers = numbers.iter();
    let mut fill = |place: &mut [f64]| place.iter_mut().for_each(|entry| *entry = *numbers.next().unwrap());
    fill(p.hessian_mut());
    fill(p.gradient_mut());
    (0..m).for_each(|i| fill(p.row_mut(i)));
    fill(p.row_lower_mut());
    fill(p.row_upper_mut());
    fill(p.lower_mut());
    fill(p.upper_mut());
    p
}
