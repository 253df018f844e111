//! Entropy coding: yes-or-no decisions to bytes and back.
//!
//! [`Predictor`] says how likely a yes is, given the contexts it is seen in; [`Encoder`] and
//! [`Decoder`] turn decisions and their likelihoods into bytes and back. What a decision means is
//! nothing this room knows. Where time counts more than bytes, [`Chance`] and what is made of it take
//! the predictor's place.
//!
//! All arithmetic is on integers, tables included: a file decodes to the same bits everywhere.

mod adaptive;
mod coder;
#[cfg(feature = "encode")]
mod logistic;
#[cfg(feature = "encode")]
mod predictor;

pub use adaptive::{Chance, Difference, Number, code_bytes};
#[cfg(feature = "encode")]
pub use coder::Encoder;
pub use coder::{Coder, Decoder};
#[cfg(feature = "encode")]
pub use logistic::Logistic;
#[cfg(feature = "encode")]
pub use predictor::{Predictor, Shape, hash};
