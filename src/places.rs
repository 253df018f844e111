//! Places as text, `1200.5,800.25`: decimals with every digit that a place has and no more, so that text and
//! place are each other's inverse. `web/src/place.ts` does the same for the viewer.

use crate::error::{Error, Result};
use crate::grid::Point;
use std::fmt;
use std::str::FromStr;

impl fmt::Display for Point<2> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y] = [0, 1].map(|axis| coordinate(self.whole[axis], self.frac[axis]));
        write!(f, "{x},{y}")
    }
}

impl FromStr for Point<2> {
    type Err = Error;

    /// Reads decimals of any length.
    fn from_str(text: &str) -> Result<Self> {
        let fault = || Error::Usage("two numbers with a comma, e.g. 1200.5,800.25".into());
        let (x, y) = text.split_once(',').ok_or_else(fault)?;
        let ((xw, xf), (yw, yf)) = (read_coordinate(x)?, read_coordinate(y)?);
        // A fraction of many nines may have been read as 1.
        Ok(Point { whole: [xw, yw], frac: [0.0; 2] }.offset([xf, yf]))
    }
}

fn coordinate(whole: i64, frac: f64) -> String {
    // The fewest digits that are read as the same number, and never an exponent.
    let frac = frac.to_string();
    match (whole, frac.strip_prefix("0.")) {
        (_, None) => whole.to_string(),
        (0.., Some(digits)) => format!("{whole}.{digits}"),
        (_, Some(digits)) => format!("-{}.{}", (whole + 1).unsigned_abs(), rest_of_one(digits)),
    }
}

/// Whole part and fraction are read apart, so that every digit of the fraction counts.
fn read_coordinate(text: &str) -> Result<(i64, f64)> {
    let text = text.trim();
    let fault = || Error::Usage(format!("“{text}” is not a decimal number of pixels"));
    let (is_negative, digits) = match text.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, text),
    };
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let only_digits = |part: &str| part.bytes().all(|b| b.is_ascii_digit());
    if (whole.is_empty() && fraction.is_empty()) || !only_digits(whole) || !only_digits(fraction) {
        return Err(fault());
    }
    let whole: i64 = if whole.is_empty() { 0 } else { whole.parse().map_err(|_| fault())? };
    let fraction = fraction.trim_end_matches('0');
    let number = |digits: &str| format!("0.{digits}0").parse::<f64>().map_err(|_| fault());
    Ok(match is_negative {
        false => (whole, number(fraction)?),
        true if fraction.is_empty() => (-whole, 0.0),
        true => (-whole - 1, number(&rest_of_one(fraction))?),
    })
}

/// The digits of 1 − 0.`digits`, of which the last is not 0: a place left of zero has a fraction that goes
/// right, and taking it from 1 as a number would lose the last of it.
fn rest_of_one(digits: &str) -> String {
    let last = digits.len() - 1;
    let rest = |(at, digit)| char::from(b'0' + b'9' - digit + u8::from(at == last));
    digits.bytes().enumerate().map(rest).collect()
}

// Not on wasm, which proptest is not built for.
#[cfg(all(test, not(target_arch = "wasm32")))]
mod tests {
    use super::*;
    use crate::camera::{Camera, MAX_SCALE};
    use proptest::prelude::*;

    #[test]
    fn a_place_keeps_its_digits() {
        let place: Point<2> = "4000.00000000000000123, -0.25".parse().unwrap();
        assert_eq!(place.whole, [4000, -1]);
        assert_eq!(place.frac, [1.23e-15, 0.75]);
        assert_eq!(place.to_string(), "4000.00000000000000123,-0.25");
        for bad in ["1", "1,", "a,b", "1e3,2", "1.2.3,4", "--1,2", "99999999999999999999,0"] {
            assert!(bad.parse::<Point<2>>().is_err(), "{bad}");
        }
    }

    #[test]
    fn a_fraction_that_is_read_as_one_is_the_next_pixel() {
        let nines = "9".repeat(30);
        let place: Point<2> = format!("7.{nines},-7.{}1", "0".repeat(30)).parse().unwrap();
        assert_eq!(place, Point { whole: [8, -7], frac: [0.0; 2] });
    }

    /// From 0 to below 1: as dense as numbers are, and more of those close to 0 than there are places.
    fn fraction() -> impl Strategy<Value = f64> {
        (0u64..1 << 53, 53..120).prop_map(|(digits, log2)| digits as f64 / 2f64.powi(log2))
    }

    proptest! {
        #[test]
        fn a_place_is_read_as_it_was_written(
            whole in any::<[i32; 2]>(), frac in [fraction(), fraction()],
        ) {
            let place = Point { whole: whole.map(i64::from), frac };
            prop_assert_eq!(place.to_string().parse::<Point<2>>().unwrap(), place);
        }

        #[test]
        fn a_view_is_shown_as_it_was_written(
            whole in [0i64..5000, 0i64..3000], frac in [fraction(), fraction()], power in -3.0..12.0,
        ) {
            let scale = 10f64.powf(power).min(MAX_SCALE);
            let mut camera = Camera::new([5000, 3000], [640, 480]);
            camera.look_at(Point { whole, frac }, scale);
            // What has been dragged and zoomed has all digits.
            camera.pan([12.3, -0.7]);
            camera.zoom(1.7, [31.0, 402.0]);
            let texts = (camera.center().to_string(), camera.scale().to_string());
            let mut again = Camera::new([5000, 3000], [640, 480]);
            again.look_at(texts.0.parse().unwrap(), texts.1.parse().unwrap());
            prop_assert_eq!(&again, &camera);
            prop_assert_eq!((again.center().to_string(), again.scale().to_string()), texts);
        }

        /// Up to 15 digits, every decimal is the shortest of its number.
        #[test]
        fn text_is_written_as_it_was_read(
            x in "(0|[1-9][0-9]{0,8})(\\.0{0,20}[0-9]{0,13}[1-9])?", y in "-?[0-9]\\.[0-9]{0,13}[1-9]",
        ) {
            let text = format!("{x},{y}");
            prop_assert_eq!(text.parse::<Point<2>>().unwrap().to_string(), text);
        }
    }
}
