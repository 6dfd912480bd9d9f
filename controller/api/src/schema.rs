//! One schema per kind of object: a generic type has one name, and the kinds must not share it.

use std::borrow::Cow;

use rts_schemas::system::SystemSpec;
use utoipa::openapi::schema::{ObjectBuilder, Schema, Type};
use utoipa::openapi::{Ref, RefOr};
use utoipa::{PartialSchema, ToSchema};

use crate::objects::{
    ComponentView, ConnectorView, EventView, Kind, ManagerView, Metadata, NodeSpecView, Object,
};

/// What is wanted of a kind of object.
pub trait OfKind {
    /// The kind.
    const KIND: Kind;
}

macro_rules! of_kind {
    ($($spec:ty => $kind:ident),+ $(,)?) => {
        $(impl OfKind for $spec {
            const KIND: Kind = Kind::$kind;
        })+
    };
}

of_kind!(
    SystemSpec => System,
    NodeSpecView => Node,
    ComponentView => Component,
    ConnectorView => Connector,
    ManagerView => Manager,
    EventView => Event,
);

impl<Spec: OfKind + ToSchema, Status: ToSchema> PartialSchema for Object<Spec, Status> {
    fn schema() -> RefOr<Schema> {
        let text = |values: &[String]| {
            let schema = ObjectBuilder::new().schema_type(Type::String);
            schema.enum_values(Some(values.to_vec()))
        };
        let reference = |name: Cow<'static, str>| Ref::from_schema_name(name);
        let kind = format!("{:?}", Spec::KIND);
        let mut object = ObjectBuilder::new()
            .schema_type(Type::Object)
            .property("apiVersion", text(&[crate::API_VERSION.to_owned()]))
            .property("kind", text(&[kind]))
            .property("metadata", reference(Metadata::name()))
            .property("spec", reference(Spec::name()))
            .property("status", reference(Status::name()));
        for field in ["apiVersion", "kind", "metadata", "spec", "status"] {
            object = object.required(field);
        }
        object.into()
    }
}

impl<Spec: OfKind + ToSchema, Status: ToSchema> ToSchema for Object<Spec, Status> {
    fn name() -> Cow<'static, str> {
        format!("{:?}", Spec::KIND).into()
    }

    fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
        fn add<T: ToSchema>(schemas: &mut Vec<(String, RefOr<Schema>)>) {
            schemas.push((T::name().into_owned(), T::schema()));
            T::schemas(schemas);
        }
        add::<Metadata>(schemas);
        add::<Spec>(schemas);
        add::<Status>(schemas);
    }
}
