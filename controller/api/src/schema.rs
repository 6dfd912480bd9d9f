//! One schema per kind of object: a generic type has one name, and the kinds must not share it.

use std::borrow::Cow;
use std::sync::Arc;

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
    /// What it looks like.
    type Schema: ToSchema;
}

macro_rules! of_kind {
    ($($spec:ty => $kind:ident as $schema:ty),+ $(,)?) => {
        $(impl OfKind for $spec {
            const KIND: Kind = Kind::$kind;
            type Schema = $schema;
        })+
    };
}

of_kind!(
    Arc<SystemSpec> => System as SystemSpec,
    NodeSpecView => Node as NodeSpecView,
    ComponentView => Component as ComponentView,
    ConnectorView => Connector as ConnectorView,
    ManagerView => Manager as ManagerView,
    EventView => Event as EventView,
);

impl<Spec: OfKind, Status: ToSchema> PartialSchema for Object<Spec, Status> {
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
            .property("spec", reference(Spec::Schema::name()))
            .property("status", reference(Status::name()));
        for field in ["apiVersion", "kind", "metadata", "spec", "status"] {
            object = object.required(field);
        }
        object.into()
    }
}

impl<Spec: OfKind, Status: ToSchema> ToSchema for Object<Spec, Status> {
    fn name() -> Cow<'static, str> {
        format!("{:?}", Spec::KIND).into()
    }

    fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
        fn add<T: ToSchema>(schemas: &mut Vec<(String, RefOr<Schema>)>) {
            schemas.push((T::name().into_owned(), T::schema()));
            T::schemas(schemas);
        }
        add::<Metadata>(schemas);
        add::<Spec::Schema>(schemas);
        add::<Status>(schemas);
    }
}
