//! One list of handlers: the router that serves them, and what describes them.

/// Makes `fn routes() -> Router<STATE>` and `fn documented() -> OpenApi` from a document and its handlers, each with
/// `#[utoipa::path]`. A daemon that serves never makes the description, which is many times as much code and memory as its
/// routes. The caller's crate has `axum`, `utoipa` and `utoipa_axum`.
#[macro_export]
macro_rules! handlers {
    ($state:ty, $document:expr; $($module:ident :: $handler:ident),+ $(,)?) => {
        /// All handlers at their paths.
        fn routes() -> ::axum::Router<$state> {
            use ::utoipa::Path as _;
            use ::utoipa_axum::PathItemExt as _;
            let mut router = ::axum::Router::new();
            $(
                ::utoipa_axum::paste! {
                    let path = $module::[<__path_ $handler>]::path();
                    for method in $module::[<__path_ $handler>]::methods() {
                        let handler = ::axum::routing::on(method.to_method_filter(), $module::$handler);
                        router = router.route(&path, handler);
                    }
                }
            )+
            router
        }

        /// What they say of themselves.
        fn documented() -> ::utoipa::openapi::OpenApi {
            ::utoipa_axum::router::OpenApiRouter::<$state>::with_openapi($document)
                $(.routes(::utoipa_axum::routes!($module::$handler)))+
                .into_openapi()
        }
    };
}
