//! The settings of controllers and reference generators.

mod controller;
mod reference;

pub use legwork_contract::posture::{ByJoint, Posture};

pub use controller::{
    ControllerKind, ControllerSettings, Damping, HoldSettings, JointLimits, Limits, PlannerSettings, PostureTracking,
    QpForm, Tracking, TrackingSettings, Weights,
};
pub use reference::{
    Adaptation, ComSettings, CommandedSpeed, GeneratorKind, LeastStep, Lift, ReferenceSettings, Replan, StanceSettings,
    StepSettings, TrajectoryKind, WalkerSettings,
};
