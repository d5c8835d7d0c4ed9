//! Reads glTF files into a [`SceneDescription`](super::description::SceneDescription).
