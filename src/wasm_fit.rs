//! What the viewer asks of the encoder: texels for a file that holds labels.

use crate::limits::Limits;
use crate::wasm_error::{tell_of_panics, thrown};
use crate::{container, open};
use wasm_bindgen::prelude::*;

/// A file with the texels fitted to the labels of another; a file that has texels stays as it is.
/// Throws an `Error` whose name is `malformed`, `unsupported` or `limit`.
#[wasm_bindgen(js_name = fitTexels)]
pub fn fit_texels(bytes: &[u8]) -> Result<Vec<u8>, JsValue> {
    tell_of_panics();
    let fitted = open(bytes, &Limits::default()).and_then(|image| container::write(&image));
    fitted.map_err(thrown)
}
