//! The law of one contact that yields: its impulse for z, which is what its spring would give (see `simultaneous.rs`), in the
//! mode that z tells: open, stick, or slip along a direction.

use super::contact_solver::norm;

/// How a contact moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Mode<const D: usize> {
    Open,
    Stick,
    /// With the impulse per normal impulse, and the share of z that friction keeps across it.
    Slip {
        along: [f64; D],
        share: f64,
    },
}

/// Friction at a contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Friction {
    /// Its coefficient.
    pub(super) coefficient: f64,
    /// Impulses are the nearest to z in the cone, and not below z on its edge.
    pub(super) nearest: bool,
}

impl<const D: usize> Mode<D> {
    /// The mode of z.
    pub(super) fn of(z: &[f64; D], friction: Friction) -> Self {
        let (normal, tangent) = (z[D - 1], norm(&z[..D - 1]));
        let Friction { coefficient, nearest } = friction;
        if tangent <= coefficient * normal {
            return if normal > 0.0 { Self::Stick } else { Self::Open };
        }
        let normal =
            if nearest { (normal + coefficient * tangent) / (1.0 + coefficient * coefficient) } else { normal };
        if normal <= 0.0 {
            return Self::Open;
        }
        // In the plane without rounding, so that the edge stays the same.
        let scale = coefficient / tangent;
        let mut along = z.map(|value| if D == 2 { coefficient.copysign(value) } else { scale * value });
        along[D - 1] = 1.0;
        Self::Slip { along, share: if D == 2 { 0.0 } else { scale * normal } }
    }

    /// Another mode for each `number` from 1 to 3, and itself for 0: open, stick, slip against `motion` and along it.
    pub(super) fn other(&self, number: u32, motion: &[f64; D], coefficient: f64) -> Self {
        let speed = norm(&motion[..D - 1]).max(f64::MIN_POSITIVE);
        let slip = |sign: f64| {
            let edge = |value: f64| if D == 2 { coefficient.copysign(value) } else { coefficient * value / speed };
            let mut along = motion.map(|value| -sign * edge(value));
            along[D - 1] = 1.0;
            Self::Slip { along, share: 0.0 }
        };
        let all = [Self::Open, Self::Stick, slip(1.0), slip(-1.0)];
        let along = |value: &[f64; D]| (0..D - 1).map(|i| value[i] * motion[i]).sum::<f64>();
        let own = match self {
            Self::Open => 0,
            Self::Stick => 1,
            Self::Slip { along: direction, .. } => 2 + usize::from(along(direction) > 0.0),
        };
        if number == 0 { *self } else { all[(own + number as usize) % all.len()] }
    }

    /// `S x`: the law's derivative by z, times `x`.
    #[inline]
    pub(super) fn times(&self, x: &[f64; D], friction: Friction) -> [f64; D] {
        match self {
            Self::Open => [0.0; D],
            Self::Stick => *x,
            Self::Slip { along, share } => {
                let square = friction.coefficient * friction.coefficient;
                let mut normal = x[D - 1];
                if friction.nearest {
                    let pull: f64 = (0..D - 1).map(|i| along[i] * x[i]).sum();
                    normal = (normal + pull) / (1.0 + square);
                }
                let mut out = along.map(|value| value * normal);
                if D == 3 && square > 0.0 {
                    // Across the direction along / coefficient.
                    let across = share * (x[1] * along[0] - x[0] * along[1]) / square;
                    out[0] -= across * along[1];
                    out[1] += across * along[0];
                }
                out
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COEFFICIENT: f64 = 0.4;

    fn friction(nearest: bool) -> Friction {
        Friction { coefficient: COEFFICIENT, nearest }
    }

    /// The impulse for z, written out: with Coulomb's law the normal part of z and what friction leaves of the tangential one, else
    /// the point of the cone nearest to z.
    fn impulse<const D: usize>(z: &[f64; D], nearest: bool) -> [f64; D] {
        let (normal, tangent) = (z[D - 1], norm(&z[..D - 1]));
        if tangent <= COEFFICIENT * normal {
            return *z;
        }
        let edge = (normal + COEFFICIENT * tangent) / (1.0 + COEFFICIENT * COEFFICIENT);
        let normal = if nearest { edge } else { normal }.max(0.0);
        let mut out = z.map(|value| value * COEFFICIENT * normal / tangent);
        out[D - 1] = normal;
        out
    }

    /// In each direction the derivative of the law, by differences.
    fn check<const D: usize>(z: [f64; D], nearest: bool, expected: &str) {
        let mode = Mode::of(&z, friction(nearest));
        let found = match mode {
            Mode::Open => "open",
            Mode::Stick => "stick",
            Mode::Slip { .. } => "slip",
        };
        assert_eq!(found, expected, "{z:?}, {nearest}");
        if let Mode::Slip { along, .. } = mode {
            let whole = impulse(&z, nearest);
            assert!((0..D).all(|i| (along[i] * whole[D - 1] - whole[i]).abs() < 1e-14), "{along:?} for {whole:?}");
        }
        let step = 1e-6;
        for axis in 0..D {
            let mut direction = [0.0; D];
            direction[axis] = 1.0;
            let [before, after] = [-step, step].map(|step| {
                let mut moved = z;
                moved[axis] += step;
                impulse(&moved, nearest)
            });
            let times = mode.times(&direction, friction(nearest));
            for i in 0..D {
                let rate = (after[i] - before[i]) / (2.0 * step);
                assert!((times[i] - rate).abs() < 1e-8, "{z:?}, {nearest}, {axis}: {times:?}, {i}: {rate}");
            }
        }
    }

    #[test]
    fn a_mode_has_the_derivative_of_the_law() {
        for nearest in [false, true] {
            check([0.1, 1.0], nearest, "stick");
            check([-0.9, 1.0], nearest, "slip");
            check([0.1, -1.0], nearest, "open");
            check([0.1, -0.2, 1.0], nearest, "stick");
            check([0.6, -0.8, 1.0], nearest, "slip");
            check([-0.3, 0.5, 0.2], nearest, "slip");
            check([0.1, 0.1, -1.0], nearest, "open");
        }
        // Pulled, but so far aside that the cone's edge is near.
        check([0.6, -0.8, -0.3], false, "open");
        check([0.6, -0.8, -0.3], true, "slip");
        check([0.9, -0.3], false, "open");
        check([0.9, -0.3], true, "slip");
        assert_eq!(Mode::of(&[0.0, 0.0], friction(false)), Mode::Open);
    }

    #[test]
    fn the_other_modes_are_all_that_there_are() {
        let motion = [0.5, 0.1];
        let modes = [
            Mode::Open,
            Mode::Stick,
            Mode::Slip { along: [-COEFFICIENT, 1.0], share: 0.0 },
            Mode::Slip { along: [COEFFICIENT, 1.0], share: 0.0 },
        ];
        for mode in modes {
            let others = [0, 1, 2, 3].map(|number| mode.other(number, &motion, COEFFICIENT));
            assert_eq!(others[0], mode);
            assert!(modes.iter().all(|one| others.contains(one)), "{others:?}");
        }
        // In space against the motion of (0.6, −0.8) and along it.
        let motion = [0.3, -0.4, 0.1];
        let slip = |number| match Mode::Stick.other(number, &motion, COEFFICIENT) {
            Mode::Slip { along, share: 0.0 } => along,
            mode => panic!("{mode:?}"),
        };
        for (number, sign) in [(1, -1.0), (2, 1.0)] {
            let expected = [sign * 0.6 * COEFFICIENT, -sign * 0.8 * COEFFICIENT, 1.0];
            let found = slip(number);
            assert!((0..3).all(|i| (found[i] - expected[i]).abs() < 1e-15), "{found:?}");
        }
        assert_eq!(Mode::Stick.other(3, &motion, COEFFICIENT), Mode::Open);
    }
}
