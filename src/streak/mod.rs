//! Streaks in pixels: the light of a pass put into a frame, with its truth.
