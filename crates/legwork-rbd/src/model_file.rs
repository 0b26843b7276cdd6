//! The TOML model format: its keys, each with its unit.

use std::collections::BTreeMap;

use serde::de::{MapAccess, Visitor, value::MapAccessDeserializer};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use toml::Spanned;

use crate::base::Base;
use crate::description::Inertias;
use crate::table::Table;

/// [m/s²], when a file gives none.
pub(crate) const GRAVITY: f64 = 9.81;

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ModelFile {
    pub(crate) name: String,
    pub(crate) base: Base,
    pub(crate) gravity_mps2: Option<f64>,
    pub(crate) torso: Option<String>,
    /// Limits of the root link's angle in the plane.
    pub(crate) base_pitch: Option<Table>,
    pub(crate) feet: Option<Vec<String>>,
    #[serde(default, skip_serializing)]
    pub(crate) locked: Vec<String>,
    #[serde(default, skip_serializing)]
    pub(crate) inertias: Inertias,
    pub(crate) forward: Option<[f64; 3]>,
    pub(crate) bodies: Vec<Spanned<BodyEntry>>,
    #[serde(default)]
    pub(crate) contacts: Vec<Spanned<ContactEntry>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) frames: Vec<Spanned<FrameEntry>>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub(crate) postures: BTreeMap<String, BTreeMap<String, f64>>,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BodyEntry {
    pub(crate) name: String,
    pub(crate) parent: Option<String>,
    pub(crate) mass_kg: Option<f64>,
    pub(crate) com_m: Option<[f64; 3]>,
    pub(crate) inertia_kgm2: Option<InertiaEntry>,
    /// Which keys it may have depends on the joint's type.
    pub(crate) joint: Option<Spanned<Table>>,
}

/// A single number about y in a planar model, otherwise the six entries.
#[derive(Clone, Copy)]
pub(crate) enum InertiaEntry {
    Planar(f64),
    Full(FullInertia),
}

#[derive(Clone, Copy, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FullInertia {
    pub(crate) xx: f64,
    pub(crate) yy: f64,
    pub(crate) zz: f64,
    #[serde(default)]
    pub(crate) xy: f64,
    #[serde(default)]
    pub(crate) xz: f64,
    #[serde(default)]
    pub(crate) yz: f64,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ContactEntry {
    pub(crate) name: String,
    pub(crate) body: String,
    pub(crate) position_m: [f64; 3],
    pub(crate) foot: Option<String>,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FrameEntry {
    pub(crate) name: String,
    pub(crate) body: String,
    pub(crate) position_m: Option<[f64; 3]>,
    pub(crate) rpy_deg: Option<[f64; 3]>,
    pub(crate) rotation: Option<[[f64; 3]; 3]>,
}

impl<'de> Deserialize<'de> for InertiaEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Entry;
        impl<'de> Visitor<'de> for Entry {
            type Value = InertiaEntry;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a number (about y, planar models) or a table { xx, yy, zz, xy, xz, yz }")
            }
            fn visit_f64<E>(self, value: f64) -> Result<InertiaEntry, E> {
                Ok(InertiaEntry::Planar(value))
            }
            #[allow(clippy::cast_precision_loss)]
            fn visit_i64<E>(self, value: i64) -> Result<InertiaEntry, E> {
                Ok(InertiaEntry::Planar(value as f64))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<InertiaEntry, A::Error> {
                FullInertia::deserialize(MapAccessDeserializer::new(map)).map(InertiaEntry::Full)
            }
        }
        deserializer.deserialize_any(Entry)
    }
}

impl Serialize for InertiaEntry {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            InertiaEntry::Planar(about_y) => about_y.serialize(serializer),
            InertiaEntry::Full(full) => full.serialize(serializer),
        }
    }
}
