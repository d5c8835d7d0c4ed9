//! The questions that the program must answer, one module each.

mod adaptive;
mod adjoint;
mod agreement;
mod agreement_map;
mod backs;
mod cameras;
mod classes;
mod determinism;
mod directions;
mod emission;
mod energy;
mod error_estimate;
mod hemisphere;
mod inspection;
mod light_choice;
mod lights;
mod lobes;
mod media;
mod merging;
mod own_light;
mod photons;

mod radius_bias;
mod reference;
mod region;
mod replay;
mod sampling;
mod scenes;
mod series;
mod specular_casters;
mod techniques;
mod touching;
mod weights;
