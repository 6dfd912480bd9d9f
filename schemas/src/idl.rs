//! OMG IDL: data types of ports and interfaces of service ports (OMG IDL 4.2, the part that CORBA 2.3 and OpenRTM use).

pub mod model;

pub use model::{
    Attribute, Constant, ConstantValue, Definition, Direction, EnumType, Exception, Interface,
    Kind, Label, Member, Operation, Parameter, Primitive, StructType, Type, Typedef, Union,
    UnionCase, Unit,
};
