//! What has to hold of every error.

use exid::fault::Fault;

/// An error is written for people: a code, a message and a remedy, none of them empty.
pub fn describes_itself(fault: &impl Fault) {
    let description = fault.describe();
    assert!(!description.code.is_empty());
    assert!(!description.message.is_empty());
    assert!(!description.remedy.is_empty());
    let place = fault.place();
    assert!(place.line != Some(0) && place.column != Some(0), "{fault}");
}
