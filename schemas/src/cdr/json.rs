//! [`Value`](super::Value) ↔ JSON, for people and scripts.
//!
//! | IDL | JSON |
//! |---|---|
//! | `boolean` | `true`, `false` |
//! | integers | numbers; beyond ±2^53 texts (`"9007199254740993"`), which any reader keeps exactly |
//! | `float`, `double` | numbers, `"NaN"`, `"Infinity"`, `"-Infinity"` |
//! | `long double` | as `double` where that is exact, otherwise its bits (`"0x3fff…"`, 32 digits) |
//! | `char`, `wchar`, `string`, `wstring` | texts |
//! | `enum` | the enumerator's name |
//! | `struct` | an object; a member that is left out is zero, an unknown one is refused |
//! | `union` | `{"$discriminator": …, "member": …}`; without `$discriminator` the first label of the member |
//! | sequences, arrays | arrays |
//! | more than 64 octets | `{"$base64": "…"}`; an array is read too |

mod read;
mod write;

pub use read::from_json;
pub use write::to_json;

/// Key of octets that would be long as numbers.
const BASE64: &str = "$base64";

/// Most octets that are written as numbers.
const FEW_OCTETS: usize = 64;

/// Integers that every reader of JSON keeps.
const EXACT: u64 = 1 << 53;
