//! Light transport, bounce by bounce: everything of neumann that knows no window.
//!
//! The rendering equation in operator form is `L = L_e + T L`, so
//! `L = Σ_k T^k L_e`: emitted light, plus light scattered once, twice, and so on. A
//! [`scene::Scene`] is what the light meets, an [`integrator::Integrator`] is how the
//! sum is guessed, a [`film::Film`] keeps its terms apart. Everything that goes from one
//! to the other is a [`film::Contribution`]: one path's share of one pixel, labelled with
//! its bounce k, its technique and its MIS weight.
//!
//! # The tour
//! Read the modules in this order; each uses only those before it.
//!
//! | module | what is in it |
//! |---|---|
//! | [`math`] | frames and rays |
//! | [`radiometry`] | colour, and the two measures of a direction |
//! | [`sampling`] | random numbers, warps, discrete choices, MIS, roulette |
//! | [`bsdf`] | how a surface scatters |
//! | [`accel`] | what a ray meets |
//! | [`memory`], [`decode`] | what files may take, and pictures in the formats of their files |
//! | [`material`] | textures, and the BSDF they amount to at a point |
//! | [`endpoint`] | both ends of a path: lights and cameras |
//! | [`scene`] | files, their description, and the scene ready to trace |
//! | [`transport`] | vertices, visibility, one integral of reflection |
//! | [`expression`] | kinds of paths, as light path expressions name them |
//! | [`film`] | contributions, layers by bounce, views |
//! | [`photons`] | light vertices kept and found again by place |
//! | [`pass`] | one iteration: its paths in parallel, and where their contributions go |
//! | [`integrator`] | the methods in lecture order, and their registry |
//! | [`render`] | iterations one after the other; the loop behind a window |
//!
//! # Use
//! The mean of 16 iterations of a built-in scene, and one term of the series at one pixel:
//!
//! ```
//! use std::sync::Arc;
//!
//! use neumann_core::film::{Film, View};
//! use neumann_core::render::{CancelToken, RenderSettings, Renderer, WorkerPool};
//! use neumann_core::scene::load::LoadOptions;
//! use neumann_core::scene::{Scene, open};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let description = open("cornell", &LoadOptions::default())?; // or the path of a .glb
//! let scene = Arc::new(Scene::build(&description));
//! let settings = RenderSettings::new(scene.cameras()[0].clone(), 64, 64);
//! let mut film = Film::new(settings.width, settings.height, settings.n_layers);
//! let mut renderer = Renderer::new(scene, settings, WorkerPool::new(None, || ())?, 0);
//! for _ in 0..16 {
//!     renderer.iterate_after(&film, &CancelToken::default())?.add_to(&mut film);
//! }
//! let once = film.radiance(View::Term(1), 0); // T L_e at the pixel on the top left
//! # assert!(film.n_iterations() == 16 && once.r >= 0.0);
//! # Ok(())
//! # }
//! ```
//!
//! The feature `pictures`, on by default, reads textures and OpenEXR skies. Without it
//! (`default-features = false`) the crate does without `image`, `png` and `exr`, and scenes that
//! have such pictures are refused.
//!
//! # Symbols
//! | here | in formulas | meaning, unit |
//! |---|---|---|
//! | `radiance`, `emitted` | `L`, `L_e` | W m⁻² sr⁻¹ per channel |
//! | importance | `W_e` | response of the camera |
//! | `f` | `f_s` | BSDF value, 1/sr, without cosine |
//! | `wo`, `wi` | `ω_o`, `ω_i` | to the previous, to the next vertex |
//! | `pdf_w`, `pdf_a` | `p_σ`, `p_A` | 1/sr, 1/m² |
//! | `pmf` | P | probability of a discrete choice |
//! | `throughput` | β | product of f cos / pdf so far |
//! | `ng`, `ns` | `n_g`, `n_s` | geometric and shading normal |
//! | `bounce` | k | power of T |
//! | `s`, `t` | s, t | vertices of light and camera subpath |
//!
//! # Sources
//! - \[Veach 1997\] E. Veach, Robust Monte Carlo Methods for Light Transport Simulation.
//! - \[VCM\] I. Georgiev, Implementing Vertex Connection and Merging, technical report, Saarland
//!   University, 2012.
//! - I. Georgiev, J. Křivánek, T. Davidovič, Ph. Slusallek, Light Transport Simulation with
//!   Vertex Connection and Merging, ACM TOG 31(6), 2012.
//! - C. Knaus, M. Zwicker, Progressive Photon Mapping: A Probabilistic Approach, ACM TOG 30(3),
//!   2011.
//! - H. W. Jensen, Realistic Image Synthesis Using Photon Mapping, 2001.
//! - \[PBR4\] M. Pharr, W. Jakob, G. Humphreys, Physically Based Rendering, 4th edition.
//! - \[Conty & Kulla 2018\] A. Conty Estevez, C. Kulla, Importance Sampling of Many Lights with
//!   Adaptive Tree Splitting, PACM CGIT 1(2).
//! - \[Burley 2020\] B. Burley, Practical Hash-based Owen Scrambling, JCGT 9(4).
//! - T. Hesterberg, Weighted Average Importance Sampling and Defensive Mixture Distributions,
//!   Technometrics 37(2), 1995.
//! - \[Preetham 1999\] A. J. Preetham, P. Shirley, B. Smits, A Practical Analytic Model for
//!   Daylight, SIGGRAPH 1999.
//! - \[Darula 2005\] S. Darula, R. Kittler, C. Gueymard, Reference luminous solar constant and
//!   solar luminance for illuminance calculations, Solar Energy 79(5).
//! - Ph. Dutré, Global Illumination Compendium, 2003.
//! - Khronos, glTF 2.0 specification and the KHR extensions named where they are used.

pub mod math;
pub mod radiometry;
pub mod sampling;

pub mod bsdf;

pub mod accel;
pub mod decode;
pub mod material;
pub mod memory;

pub mod endpoint;
pub mod scene;

pub mod transport;

pub mod expression;

pub mod film;
pub mod photons;

pub mod pass;

pub mod integrator;

pub mod render;
