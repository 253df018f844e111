//! Entropy coding: yes-or-no decisions to bytes and back.
//!
//! [`Predictor`] says how likely a yes is, given the contexts it is seen in; [`Encoder`] and
//! [`Decoder`] turn decisions and their likelihoods into bytes and back. What a decision means is
//! nothing this room knows.
//!
//! All arithmetic is on integers, tables included: a file decodes to the same bits everywhere.

mod coder;
mod logistic;
mod predictor;

#[cfg(feature = "encode")]
pub use coder::Encoder;
pub use coder::{Coder, Decoder};
pub use logistic::Logistic;
pub use predictor::{Predictor, Shape, hash};
