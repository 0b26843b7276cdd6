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
