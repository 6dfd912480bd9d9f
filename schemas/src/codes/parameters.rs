//! Codes of configuration parameters: constraints, widgets, values.

use super::Code;

pub(super) const CODES: &[Code] = &[
    Code {
        code: "bad-constraint",
        title: "the constraint of a parameter cannot be read",
        explain: "\
A constraint says which values are allowed. As text (`__constraints__` in an RTS Profile, the editor's field):

    0 <= x <= 10           a range; also `x > 0`
    (left, right)          one of these
    x < 1, x < 2           one for each item of a list
    {a: x < 1, b: 3}       one for each named item

In an RTC Profile it is written as elements, which compare with a number or list values with `rtc:Or`. One that cannot be
read allows everything, and editors show a plain text box.",
    },
    Code {
        code: "bad-parameter-value",
        title: "the value of a parameter is none of its type",
        explain: "\
The RTC Profile (or `__type__` in the RTS Profile) says what the component expects. Another value is refused when it is
set, and the component goes on with its default: the robot then does something else than the file says. Values that an
overlay gives are held against the type too.

    int       5            not `5.0`, not `fast`
    double    0.5
    std::vector<double>    0.5,1.0

Write a value of the type.",
    },
    Code {
        code: "bad-widget",
        title: "an editor cannot show a parameter as it is asked to",
        explain: "\
`__widget__` is one of `text`, `slider`, `spin`, `radio`, `checkbox`, `ordered_list`; the second and third may have a step:
`slider.0.1`. A slider or spinner needs a range as its constraint (`0 <= x <= 10`), the last three a choice (`(a, b)`).
Otherwise editors show a plain text box, and nobody notices a wrong value.

Mend the word, or add the constraint.",
    },
    Code {
        code: "unknown-parameter",
        title: "a parameter is named that is not there",
        explain: "\
`__constraints__`, `__widget__` and `__type__` speak of parameters by name, and no configuration set has this one. After a
parameter was renamed, its constraint guards nothing.

An overlay may give a value to a parameter that the profile has in no set of the component, though it has others. The value
is sent all the same, since the component may know more than its profile says; if it does not, it refuses the value and does
not start. With `--rtc` the RTC Profile of the component decides instead (`rtc-unknown-parameter`).

    configuration:
      sets:
        default: { frequenzy: 2.0 }     # frequency

Mend the name, or remove the entry. A parameter that the component does know can be added to the profile.",
    },
    Code {
        code: "value-outside-constraint",
        title: "the value of a parameter is outside its constraint",
        explain: "\
The author of the component wrote down which values make sense. The component itself does not check that: OpenRTM sets
any value, and what happens is up to the code. Values that an overlay gives are held against the constraints too.

    constraint 0 <= x <= 1.0, value 2.5      wrong

Write a value that the help names as allowed, or mend the constraint.",
    },
];
