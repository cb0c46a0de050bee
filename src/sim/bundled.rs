//! The scenarios that come with the program.

/// Name and text of each, see [`ScenarioFile`](super::ScenarioFile).
pub const BUNDLED: [(&str, &str); 8] = [
    ("paper", include_str!("../../scenarios/paper.toml")),
    ("experiment", include_str!("../../scenarios/experiment.toml")),
    ("tour", include_str!("../../scenarios/tour.toml")),
    ("fast", include_str!("../../scenarios/fast.toml")),
    ("orbit", include_str!("../../scenarios/orbit.toml")),
    ("gust", include_str!("../../scenarios/gust.toml")),
    ("detour", include_str!("../../scenarios/detour.toml")),
    ("unreachable", include_str!("../../scenarios/unreachable.toml")),
];
