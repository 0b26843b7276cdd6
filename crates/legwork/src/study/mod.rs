//! Studies: many rollouts by a plan, and what they say together.
