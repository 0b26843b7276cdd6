//! Why claims are not reproduced, as far as known. These are explanations, not measurements.

use crate::case::Reading;

/// Of all claims about the push in the default set.
const FALLS: &str = "In this reading the push falls with the baseline's gains at 220 Nm, so that its sweeps compare \
                     falls; the other reading stands. Which one the thesis used is not known.";
const SUPPORT: Option<Reading> = Some(Reading::BaseOfSupport);
const DISPLACEMENT: Option<Reading> = Some(Reading::Displacement);

const REASONS: &[(&str, Option<Reading>, &str)] = &[
    (
        "6.1-a",
        None,
        "There is such a limit, but it is lower (limits: lowest torque limit). It depends on how far the robot \
         crouches, on lengths and masses, none of which the thesis gives.",
    ),
    ("6.1-b", DISPLACEMENT, FALLS),
    (
        "6.1-d",
        DISPLACEMENT,
        "The walk's CoM error stops sinking near 220 Nm. How far the push goes is decided by small steps by chance \
         (docs/parameters.md), more than by the limit.",
    ),
    (
        "6.1-d",
        SUPPORT,
        "The walk's CoM error stops sinking near 220 Nm. The push's torques do not reach the limit from there on.",
    ),
    (
        "6.1-e",
        None,
        "From 220 Nm up few ticks reach the limit, so that means hardly change; in the push of the default set a \
         tighter limit costs more.",
    ),
    ("6.1-f", DISPLACEMENT, FALLS),
    ("6.1-g", DISPLACEMENT, FALLS),
    (
        "6.3.1-a",
        None,
        "A low force limit lets the robot sink and lag: that is an error of the CoM. Feet and torso are tracked as \
         before.",
    ),
    ("6.3.1-b", DISPLACEMENT, FALLS),
    (
        "6.3.1-b",
        SUPPORT,
        "There is such a limit, but it is lower (limits: lowest force limit). It depends on the step time and on the \
         limit of the momentum rate, which the thesis does not give.",
    ),
    ("6.3.1-c", DISPLACEMENT, FALLS),
    ("6.3.1-c", SUPPORT, "The push's peak force does not reach the limit."),
    (
        "6.3.1-d",
        None,
        "The CoM's error of the walk sinks up to about 1000 N; the published figures cannot be read from the text.",
    ),
    ("6.3.2-a", DISPLACEMENT, FALLS),
    (
        "6.3.2-b",
        None,
        "The instability comes at a weight ten times as high: 1 degrades the CoM, 10 makes the robot fall. Only \
         ratios of weights count, and the one to the momentum weight decides here (question operating-weights).",
    ),
    (
        "6.3.2-c",
        None,
        "The CoM moves too late, as the thesis says; but what the program gives up is the momentum, not the feet \
         (question operating-weights).",
    ),
    ("6.3.3-a", DISPLACEMENT, FALLS),
    (
        "6.3.3-b",
        None,
        "The momentum gives way before the feet do, which weigh ten thousand times as much (question \
         operating-weights).",
    ),
    ("6.3.3-c", DISPLACEMENT, FALLS),
    ("6.3.3-c", SUPPORT, "The push falls before its mean torque has grown by as much."),
    (
        "6.3.4-a",
        None,
        "Tracking does get poor, but only where the momentum weight is as small as the operating weights (runs: \
         controller.weights.momentum=1e-4 and 1e-5). Above, feet, torso and momentum can be tracked together, so that \
         their ratio matters little.",
    ),
    ("6.3.4-b", None, "As 6.3.4-a: the walk falls at 1e-5, not below 10."),
    ("6.3.4-c", DISPLACEMENT, FALLS),
    (
        "6.3.4-c",
        SUPPORT,
        "The walk falls at some levels from about 300 up and stands at others, with poor feet and a torso far off.",
    ),
    ("6.3.5-a", DISPLACEMENT, FALLS),
    ("6.3.5-b", DISPLACEMENT, FALLS),
    (
        "6.3.5-c",
        None,
        "In the walk it does. In the push the torque is that of standing for most of the time, which no feet weight \
         changes.",
    ),
    ("6.3.5-d", SUPPORT, "The push's torso is hardly disturbed at any weight: its swings need no torque at the limit."),
    (
        "6.3.5-e",
        DISPLACEMENT,
        "The walk does, at the very trigger. In the push the contradiction comes in mid-swing first, with the limits \
         on torque and on the standing foot's friction.",
    ),
    (
        "6.3.5-e",
        SUPPORT,
        "Its steps take 0.25 s. With steps of 0.20 s the walk meets it as well (question hard-feet): the thesis's \
         step time is not known.",
    ),
    (
        "6.3.5-f",
        None,
        "Here the hard task becomes a cost in the ticks that have no solution. The thesis has no such rule; its robot \
         is left without torques there.",
    ),
    (
        "6.3.6-b",
        None,
        "At low weights the torso leans by tenths of a radian, which moves everything. The levels that the thesis \
         tried cannot be read from the text; from 1e4 to 1e5 little changes here too.",
    ),
    ("6.3.6-d", DISPLACEMENT, FALLS),
    ("6.3.6-d", SUPPORT, "All rise, the push's mean torque by less than counts."),
    (
        "6.3.7-c",
        None,
        "The feet error changes little and not in one direction. Why is not known; feet are tracked stiffly at all of \
         these gains.",
    ),
    ("6.3.7-d", DISPLACEMENT, FALLS),
    (
        "6.3.7-d",
        SUPPORT,
        "From 600 N/m up it has none; at lower gains the robot falls or recovers late. The thesis's range is not \
         known.",
    ),
    (
        "6.3.7-f",
        None,
        "With a low gain the robot sinks (sweeps: com_error_vertical_m), and bent knees cost torque. Higher gains \
         carry it higher.",
    ),
    ("6.3.7-g", DISPLACEMENT, FALLS),
    (
        "6.3.7-g",
        SUPPORT,
        "The mean torque does sink, slightly; two low gains fall, and u² has its least value in between.",
    ),
    ("6.3.8-a", DISPLACEMENT, FALLS),
    ("6.3.8-b", DISPLACEMENT, FALLS),
    ("6.3.8-b", SUPPORT, "In the walk the feet error sinks about as much above the baseline's gain as below."),
    (
        "6.3.8-c",
        None,
        "The CoM's error sinks up to about the baseline's gain and rises above, to a multiple. The thesis's range is \
         not known.",
    ),
    ("6.3.8-d", DISPLACEMENT, FALLS),
    ("6.3.8-d", SUPPORT, "The walk's does. The push's mean torque rises slightly, by less than 4 % over all gains."),
    (
        "6.4-a",
        None,
        "Above a feet weight of about 1e6 the feet's accelerations are met wherever that is possible, so that a \
         higher weight changes nothing (sweep feet-weight), and the gain alone decides.",
    ),
    ("7.1.2-a", DISPLACEMENT, FALLS),
    (
        "7.1.3-a",
        None,
        "The mean is met. The peak is that of the first step from rest: the PD law (4.4) alone still has 0.042 m left \
         after 0.4 s where the reference starts at the robot's CoM with a velocity step. The thesis says that the CoM \
         did not start on its reference, but not where.",
    ),
    (
        "7.1.3-c",
        None,
        "The limit is set by step time, step length and delay, which the thesis gives no value of. Followed closely \
         (limits: top speed followed) is a slower walk.",
    ),
    ("7.1.3-d", None, "The speed is met, but not by the torque: as at 220 Nm, step time and step length set it."),
    ("7.1.3-e", None, "As the peak of 7.1.3-a: where the thesis's CoM started is not known."),
    (
        "7.1.3-f",
        None,
        "The swing (4.1), (4.2) asks for its largest acceleration at its first instant, and that is when the foot \
         falls behind. Why the thesis's foot errs at the top is not known.",
    ),
    ("7.1.3-g", SUPPORT, "Its swing is slower, and the feet err ten times less than published: the torque suffices."),
    (
        "7.1.4-b",
        None,
        "140 Ns are survived, and more. The thesis shows no larger push, so that its 140 Ns may be what was tried.",
    ),
    (
        "7.1.4-c",
        DISPLACEMENT,
        "The least step is the foot's way here, which lets the rear foot land just ahead of the other; the lunge that \
         follows carries the robot further. The other reading avoids that.",
    ),
    ("7.1.4-d", DISPLACEMENT, "As 7.1.4-c: the lunge also sinks and tips the robot."),
    ("7.1.5-a", DISPLACEMENT, FALLS),
    (
        "7.1.5-a",
        SUPPORT,
        "In the push a lower momentum weight and a higher torso weight would lower the torso's error, which is below \
         the published one already.",
    ),
    ("7.1.5-b", None, "The baseline's feet err less than published, so that less is to be gained."),
    ("7.1.5-c", DISPLACEMENT, "The mean CoM error sinks as well, by a little more than counts."),
    ("7.1.5-d", DISPLACEMENT, FALLS),
    ("7.1.5-e", DISPLACEMENT, FALLS),
    ("7.1.5-e", SUPPORT, "The baseline's peak is below the final design's published one already."),
    ("7.1.5-f", DISPLACEMENT, FALLS),
    ("7.1.5-f", SUPPORT, "The baseline's distance is the final design's published one already."),
    (
        "7.2.1-b",
        DISPLACEMENT,
        "Over the walk both sums are a few centimetres: the error neither grows nor shrinks clearly in either phase.",
    ),
    ("7.4-a", DISPLACEMENT, FALLS),
    ("7.4-a", SUPPORT, "As 6.3.5-e: with this reading's step time hard feet are always feasible."),
    ("8.1.2-a", DISPLACEMENT, FALLS),
    ("8.1.2-b", DISPLACEMENT, FALLS),
];

/// The reason for a claim in a reading.
pub(super) fn why(id: &str, reading: Reading) -> Option<&'static str> {
    let of = |(claim, only, _): &&(&str, Option<Reading>, _)| *claim == id && only.is_none_or(|only| only == reading);
    REASONS.iter().find(of).map(|(.., reason)| *reason)
}

/// The claims that have one.
#[cfg(test)]
pub(super) fn ids() -> impl Iterator<Item = &'static str> {
    REASONS.iter().map(|(id, ..)| *id)
}
