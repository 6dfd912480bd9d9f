//! Codes of IDL files.

use super::Code;

pub(super) const CODES: &[Code] = &[
    Code {
        code: "idl-syntax",
        title: "something else is expected here",
        explain: "\
The file does not have the form of IDL at this place: a `;` is missing, a bracket is not closed, a keyword stands where a
name must be. Reading goes on behind the next `;`, so that further mistakes are told at once.

    struct Pose {
      double x        // a `;` is missing
      double y;
    };

Write what is expected. A member, a definition and a module end with `;`; structs, unions, enums and modules have something
in them.",
    },
    Code {
        code: "idl-bad-word",
        title: "a number, a character, a string or a comment is not well formed",
        explain: "\
Numbers are decimal, octal (with a leading 0) or hexadecimal (0x) and have no suffix; characters stand in single quotes,
strings in double quotes and within one line; names have ASCII letters, digits and `_`; a comment `/*` ends with `*/`.

    const long MASK = 08;        // octal has no 8
    const double RATE = 1.0f;    // IDL has no suffixes

Write it as IDL knows it.",
    },
    Code {
        code: "idl-bad-directive",
        title: "a line that begins with # is not understood",
        explain: "\
Understood are `#include`, `#define` and `#undef` of names without parameters, `#if`, `#ifdef`, `#ifndef`, `#elif`, `#else`,
`#endif`, `#error`, `#warning` and `#pragma`. Each condition ends in the file that it began in.

    #ifndef ARM_IDL
    #define ARM_IDL
    module Arm { const long AXES = 6; };
    // `#endif` is missing

Mend its spelling, or end the condition.",
    },
    Code {
        code: "idl-bad-value",
        title: "a constant expression gives no value of its type",
        explain: "\
A constant, a bound, a dimension and a label take values of their type only: whole numbers within its range, floating-point
numbers with a point, TRUE and FALSE, strings within their bound, enumerators of their enum. Bounds and dimensions begin
at 1.

    const short LIMIT = 70000;   // a short ends at 32767
    const double RATE = 5;       // 5.0

Write another value, or use a larger type.",
    },
    Code {
        code: "idl-bad-label",
        title: "a label of a union can never be chosen",
        explain: "\
Each value chooses one case of a union. A label that stands twice, or a `default` where all values have a case of their own,
would leave open which one is meant.

    union Answer switch (boolean) {
      case TRUE: long value;
      case FALSE: string why;
      default: octet never;      // no value is left
    };

Leave it out.",
    },
    Code {
        code: "idl-bad-operation",
        title: "an operation promises what it cannot do",
        explain: "\
Nobody waits for the answer of a `oneway` operation: it has no result, no `out` or `inout` parameter, and raises nothing.

    interface Arm {
      oneway long stop();        // oneway void stop();
    };

Leave `oneway` out, or what would be answered. An exception is named once in `raises`.",
    },
    Code {
        code: "idl-wrong-name",
        title: "a name stands for something of another kind",
        explain: "\
Where a type is expected a constant, an exception or a member has no meaning; a union is decided by a whole number, a
`char`, a `boolean` or an enum; `raises` names exceptions.

    exception Refused { string why; };
    struct Answer { Refused why; };   // an exception is no type

Name something of the kind that is expected.",
    },
    Code {
        code: "idl-unknown-name",
        title: "a name is not declared",
        explain: "\
IDL reads from top to bottom: a name is declared, or its file included, before it is used. Within a module the names of the
modules around are known without their prefix; those of other modules are not.

    module Arm { struct Pose { double x; }; };
    struct Last { Pose pose; };       // Arm::Pose

Mend its spelling, write its module before it, or include its file. Enumerators stand beside their enum, not within it.",
    },
    Code {
        code: "idl-name-case",
        title: "two names differ in case only",
        explain: "\
IDL is made for languages that do not tell names apart by case: names of one scope must differ in more than case, also from
keywords and from names of other scopes that were used there, and a name is always written as it was declared.

    struct Time { long sec; };
    struct Event { Time time; };      // `Time at`, or `::Time time`

Give one of them another name. A keyword can be a name with an underscore before it, which is not part of it: `_struct`.",
    },
    Code {
        code: "idl-name-taken",
        title: "a name has a meaning already",
        explain: "\
In one scope a name is declared once; a scope's own name, names that were used in it and inherited operations count too.
Only modules may be opened again, and structs, unions and interfaces be announced before they are defined. A repository id
is set once.

    enum Arm { LEFT, RIGHT };
    enum Leg { LEFT, RIGHT };         // enumerators stand beside their enum

Give one of them another name, or put it into a module.",
    },
    Code {
        code: "idl-incomplete-type",
        title: "a type is used before it is defined, or within itself",
        explain: "\
A struct or union that is only announced, or that is being defined, has no known size. A sequence of it may be used: it may
be empty. What is announced must be defined in the end; for an interface this is a warning only.

    struct Node {
      Node child;                     // sequence<Node> children
    };

Define it before, or use a sequence.",
    },
    Code {
        code: "idl-inheritance",
        title: "an interface cannot inherit this",
        explain: "\
An interface inherits from other interfaces that are defined, each named once; an abstract one from abstract ones, one that
is not local from none that is. Two bases must not have operations of one name, and a type that several bases have must be
named with its interface.

    interface Left { void stop(); };
    interface Right { void stop(); };
    interface Both : Left, Right {};

Leave one out, or rename one of the operations.",
    },
    Code {
        code: "idl-include",
        title: "an included file is not there or cannot be read",
        explain: "\
A file in quotes is looked for beside the file that names it, then in the folders of -I, one in angle brackets in those
folders only. The data types of OpenRTM-aist are always found: BasicDataType.idl, ExtendedDataTypes.idl and
InterfaceDataTypes.idl, also below rtm/idl/.

    #include \"Arm.idl\"

Mend the name, or name its folder: `rtsctl idl check FILE -I FOLDER`.",
    },
    Code {
        code: "idl-said",
        title: "the file itself says #error or #warning",
        explain: "\
Its author put this line where the file should not be read, or not be read so: mostly a condition before it asks for a macro
that is not defined.

    #ifndef AXES
    #error define AXES first
    #endif

Do as it says.",
    },
    Code {
        code: "idl-not-supported",
        title: "this part of IDL is not read",
        explain: "\
Native types, value types, fixed-point numbers, annotations of IDL 4 and macros with parameters are not read: no data port
of OpenRTM-aist uses them.

    native Handle;
    typedef fixed<8,2> Money;

Use a struct of the values that are to be sent, `double` for fixed-point numbers, and write macros out.",
    },
    Code {
        code: "idl-too-large",
        title: "something is larger or deeper than is read",
        explain: "\
Reading, and every program that uses what was read, is bounded: 64 levels and types within each other, 32 files that include
each other, 1000 includes, 2^26 numbers in one value, 256 inherited interfaces. A file that includes itself without a guard
reaches such a bound too.

    typedef double Map[100000][100000];   // sequence<double>

Use sequences for large values, and guard files: `#ifndef NAME`, `#define NAME`, `#endif`.",
    },
    Code {
        code: "idl-not-text",
        title: "the file is no text",
        explain: "\
An IDL file is text in UTF-8; comments in Shift_JIS or EUC-JP are read too. This one has bytes that are none of them, so it
is something else: a compiled file, an archive, a damaged copy.

Name another file.",
    },
];
