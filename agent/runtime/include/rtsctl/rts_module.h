/* The interface between rtsctl's managers and modules, version 1. docs/abi.md explains it.
 *
 * Made of agent/runtime/src/abi.rs; do not edit. C11 and C++11. */

#ifndef RTSCTL_RTS_MODULE_H
#define RTSCTL_RTS_MODULE_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

// Version of this ABI.
#define RTS_ABI_VERSION 1

// Encoding of samples: CDR (XCDR1), little endian, without an encapsulation header.
#define RTS_ENCODING_CDR_LE 1

// Direction of a data port: it reads.
#define RTS_PORT_IN 0

// Direction of a data port: it writes.
#define RTS_PORT_OUT 1

// A service port's interface is offered to others.
#define RTS_SERVICE_PROVIDED 0

// A service port's interface is used of others.
#define RTS_SERVICE_REQUIRED 1

// Execution context: a cycle at a fixed rate.
#define RTS_EXECUTION_PERIODIC 0

// Execution context: a cycle when a sample arrives or rts_host_t.wake is called.
#define RTS_EXECUTION_EVENT_DRIVEN 1

// Execution context: a cycle when somebody asks for one.
#define RTS_EXECUTION_EXTERNAL 2

// Activity type PERIODIC.
#define RTS_ACTIVITY_PERIODIC 0

// Activity type SPORADIC.
#define RTS_ACTIVITY_SPORADIC 1

// Activity type EVENT_DRIVEN.
#define RTS_ACTIVITY_EVENT_DRIVEN 2

// Clock for rts_host_t.now: since 1970-01-01 UTC. It may jump.
#define RTS_CLOCK_REALTIME 0

// Clock for rts_host_t.now: since a moment that is the same for the whole process. It never goes back.
#define RTS_CLOCK_MONOTONIC 1

// All callbacks, for rts_module_t.actions.
#define RTS_ALL_ACTIONS ((1 << 13) - 1)

// RTC_OK.
#define RTS_OK 0

// RTC_ERROR.
#define RTS_ERROR 1

// BAD_PARAMETER.
#define RTS_BAD_PARAMETER 2

// UNSUPPORTED.
#define RTS_UNSUPPORTED 3

// OUT_OF_RESOURCES.
#define RTS_OUT_OF_RESOURCES 4

// PRECONDITION_NOT_MET.
#define RTS_PRECONDITION_NOT_MET 5

// Of a callback only: OK, and this one does nothing, so the instance need not be called for it again.
#define RTS_NOT_IMPLEMENTED 100

// Done.
#define RTS_PORT_OK 0

// Anything else.
#define RTS_PORT_ERROR 1

// The buffer failed.
#define RTS_PORT_BUFFER_ERROR 2

// The buffer of a connector was full, and its policy kept the new sample out.
#define RTS_PORT_BUFFER_FULL 3

// There is no sample. Not an error.
#define RTS_PORT_BUFFER_EMPTY 4

// The time to wait for a buffer is over.
#define RTS_PORT_BUFFER_TIMEOUT 5

// The way out of a connector was full.
#define RTS_PORT_SEND_FULL 6

// The time to wait for the way out is over.
#define RTS_PORT_SEND_TIMEOUT 7

// Nothing came from the other end.
#define RTS_PORT_RECV_EMPTY 8

// The time to wait for the other end is over.
#define RTS_PORT_RECV_TIMEOUT 9

// No such port, another type or encoding, or a struct that cannot be used.
#define RTS_PORT_INVALID_ARGS 10

// Not now.
#define RTS_PORT_PRECONDITION_NOT_MET 11

// The other end of a connector is lost.
#define RTS_PORT_CONNECTION_LOST 12

// Not known.
#define RTS_PORT_UNKNOWN_ERROR 13

// on_initialize.
#define RTS_ON_INITIALIZE 0

// on_finalize.
#define RTS_ON_FINALIZE 1

// on_startup: the execution context starts.
#define RTS_ON_STARTUP 2

// on_shutdown: the execution context stops.
#define RTS_ON_SHUTDOWN 3

// on_activated.
#define RTS_ON_ACTIVATED 4

// on_deactivated.
#define RTS_ON_DEACTIVATED 5

// on_aborting: it goes to Error.
#define RTS_ON_ABORTING 6

// on_error: it is in Error, once a cycle.
#define RTS_ON_ERROR 7

// on_reset.
#define RTS_ON_RESET 8

// on_execute, once a cycle while Active.
#define RTS_ON_EXECUTE 9

// on_state_update, after each on_execute.
#define RTS_ON_STATE_UPDATE 10

// on_rate_changed.
#define RTS_ON_RATE_CHANGED 11

// on_configured: values were set while it runs, all of one update before the call.
#define RTS_ON_CONFIGURED 12

// How many callbacks there are.
#define RTS_CALLBACKS 13

// Borrowed UTF-8 text. The one struct that never grows.
typedef struct rts_text_t {
  // First byte; may be anything when len is 0.
  const uint8_t *data;
  // Length in bytes.
  size_t len;
} rts_text_t;

// A borrowed sample. Whoever passes one sets abi_version and size, also when it is to be filled.
typedef struct rts_buffer_t {
  // RTS_ABI_VERSION.
  uint32_t abi_version;
  // Size of this struct for the compiler of its sender.
  uint32_t size;
  // IDL repository id of the type (IDL:RTC/TimedLong:1.0).
  struct rts_text_t type_id;
  // RTS_ENCODING_CDR_LE.
  uint32_t encoding;
  // Zero.
  uint32_t reserved;
  // First byte.
  const uint8_t *data;
  // Length in bytes.
  size_t len;
} rts_buffer_t;

// Memory of the manager that a sample is written into, so that it is not copied. The module sets abi_version and
// size, rts_host_t.loan the rest.
typedef struct rts_loan_t {
  // RTS_ABI_VERSION.
  uint32_t abi_version;
  // Size of this struct for the compiler of the module.
  uint32_t size;
  // Names the loan when it is given back; never 0.
  uint64_t token;
  // First byte, at a multiple of 8. All bytes can be read and written, and are zero at first.
  uint8_t *data;
  // Length in bytes.
  size_t len;
} rts_loan_t;

// A data port of a type. Ports are named by their index in rts_module_t.ports.
typedef struct rts_port_t {
  // RTS_ABI_VERSION.
  uint32_t abi_version;
  // Size of this struct for the compiler of the module: the distance of two in a list.
  uint32_t size;
  // Bare name.
  struct rts_text_t name;
  // IDL repository id.
  struct rts_text_t type_id;
  // RTS_PORT_IN or RTS_PORT_OUT.
  uint32_t direction;
  // Zero.
  uint32_t reserved;
} rts_port_t;

// An interface of a service port. Managers of this version show it and connect nothing to it.
typedef struct rts_service_t {
  // RTS_ABI_VERSION.
  uint32_t abi_version;
  // Size of this struct for the compiler of the module: the distance of two in a list.
  uint32_t size;
  // Name of the port. A port with several interfaces is in the list as often.
  struct rts_text_t port;
  // Name of the interface in the port.
  struct rts_text_t name;
  // IDL repository id of the interface (IDL:Acme/Arm:1.0).
  struct rts_text_t interface_id;
  // RTS_SERVICE_PROVIDED or RTS_SERVICE_REQUIRED.
  uint32_t polarity;
  // Zero.
  uint32_t reserved;
} rts_service_t;

// A configuration parameter of a type.
typedef struct rts_parameter_t {
  // RTS_ABI_VERSION.
  uint32_t abi_version;
  // Size of this struct for the compiler of the module: the distance of two in a list.
  uint32_t size;
  // Name.
  struct rts_text_t name;
  // Default value as text. It must be of the type and keep the constraint.
  struct rts_text_t default_value;
  // Type as an RTC Profile names it (double, int, string, std::vector<double>); empty when any text will do.
  struct rts_text_t value_type;
  // Unit (m/s); may be empty.
  struct rts_text_t unit;
  // Constraint as an RTC Profile has it (0<=x<=10, (slow,fast)); empty when there is none.
  struct rts_text_t constraint;
  // One line; may be empty.
  struct rts_text_t description;
} rts_parameter_t;

// What a manager offers to one instance. context comes first in every call.
//
// log, now, rate and wake may be called by any thread, from create until destroy is called. All others only
// by the thread that the manager calls the instance from, during such a call.
typedef struct rts_host_t {
  // RTS_ABI_VERSION.
  uint32_t abi_version;
  // Size of this struct for the compiler of the manager.
  uint32_t size;
  // Belongs to the manager.
  void *context;
  // Writes a line to the component's log. Levels: 0 trace, 1 debug, 2 info, 3 warn, 4 error.
  void (*log)(void *context, uint32_t level, struct rts_text_t message);
  // Says why the next return code is not OK.
  void (*fail)(void *context, struct rts_text_t reason);
  // Nanoseconds of a clock; 0 for a clock that is not known.
  int64_t (*now)(void *context, uint32_t clock);
  // Rate in Hz of the execution context that runs the instance.
  double (*rate)(void *context);
  // Asks an event-driven execution context for a cycle. Several calls before it begins are one. Returns a return code:
  // PRECONDITION_NOT_MET when the context is not event-driven.
  int32_t (*wake)(void *context);
  // Writes a sample to an out-port; copied before it returns. Returns a port status.
  int32_t (*write)(void *context, uint32_t port, const struct rts_buffer_t *sample);
  // Takes the next sample of an in-port among those that had arrived when the running callback began, so a loop
  // that reads all ends. On PORT_OK sample is borrowed until the next read of the same port or the end of the
  // instance; on any other port status, such as PORT_BUFFER_EMPTY, it is untouched.
  int32_t (*read)(void *context, uint32_t port, struct rts_buffer_t *sample);
  // 1 when rts_host_t.read would give a sample, else 0.
  int32_t (*is_new)(void *context, uint32_t port);
  // Lends memory for a sample of an out-port. Returns a port status; loan is filled on PORT_OK only. It is given
  // back by rts_host_t.publish or rts_host_t.discard, at the latest when the instance ends.
  int32_t (*loan)(void *context, uint32_t port, size_t len, struct rts_loan_t *loan);
  // Writes the first len bytes of a loan, a sample in RTS_ENCODING_CDR_LE, to the port that it was lent for, without
  // a copy. The memory belongs to the manager from then on, whatever the port status that is returned.
  int32_t (*publish)(void *context, uint64_t token, size_t len);
  // Gives a loan back unused.
  void (*discard)(void *context, uint64_t token);
} rts_host_t;

// What a module is.
typedef struct rts_module_t {
  // RTS_ABI_VERSION.
  uint32_t abi_version;
  // Size of this struct for the compiler of the module.
  uint32_t size;
  // Type name.
  struct rts_text_t type_name;
  // Vendor.
  struct rts_text_t vendor;
  // Category.
  struct rts_text_t category;
  // Version of the component type.
  struct rts_text_t version;
  // One line.
  struct rts_text_t description;
  // IDL source of the types that are the module's own; may be empty.
  struct rts_text_t idl;
  // Rate in Hz when nothing else is said.
  double default_rate;
  // Execution context that it wants when nothing else is said: RTS_EXECUTION_PERIODIC and its like.
  uint32_t execution_kind;
  // RTS_ACTIVITY_PERIODIC and its like: for people and tools.
  uint32_t activity_type;
  // Most instances in one process; 0 for any number.
  uint32_t max_instances;
  // Callbacks that it implements, bit 1 << number each. The others are never called.
  uint32_t actions;
  // Data ports.
  const struct rts_port_t *ports;
  // Number of data ports.
  size_t ports_len;
  // Parameters.
  const struct rts_parameter_t *parameters;
  // Number of parameters.
  size_t parameters_len;
  // Interfaces of service ports.
  const struct rts_service_t *services;
  // Number of interfaces of service ports.
  size_t services_len;
  // Makes an instance. host lives as long as the instance. Returns a return code; instance is set on OK only,
  // and is then not null.
  int32_t (*create)(const struct rts_host_t *host, void **instance);
  // Frees an instance.
  void (*destroy)(void *instance);
  // Calls a callback by its number. Returns a return code.
  int32_t (*callback)(void *instance, uint32_t callback);
  // Sets a parameter. Returns a return code: BAD_PARAMETER when the value is refused, and the old one stays.
  int32_t (*configure)(void *instance, struct rts_text_t name, struct rts_text_t value);
} rts_module_t;

// Type of the exported function. The module lives as long as the process.
typedef const struct rts_module_t *(*rts_entry_t)(void);


#if defined(__GNUC__)
#define RTS_EXPORT __attribute__((visibility("default")))
#else
#define RTS_EXPORT
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** The one function that a module exports. */
RTS_EXPORT const rts_module_t *rts_module_v1(void);

/** A text that ends with a zero, as the interface has it. */
static inline rts_text_t rts_text(const char *text) {
  rts_text_t lent;
  lent.data = (const uint8_t *)text;
  lent.len = strlen(text);
  return lent;
}

#ifdef __cplusplus
}
#endif

/** Whether a struct of the other side goes as far as a field: RTS_HAS(rts_host_t, host, publish). */
#define RTS_HAS(type, it, field) ((it)->size >= offsetof(type, field) + sizeof((it)->field))

#ifdef __cplusplus
#define RTS_STATIC_ASSERT(what) static_assert(what, #what)
#else
#define RTS_STATIC_ASSERT(what) _Static_assert(what, #what)
#endif

/* What both sides must agree on. */
#if UINTPTR_MAX == UINT64_MAX
RTS_STATIC_ASSERT(sizeof(rts_text_t) == 16);
RTS_STATIC_ASSERT(offsetof(rts_text_t, data) == 0);
RTS_STATIC_ASSERT(offsetof(rts_text_t, len) == 8);
RTS_STATIC_ASSERT(sizeof(rts_buffer_t) == 48);
RTS_STATIC_ASSERT(offsetof(rts_buffer_t, abi_version) == 0);
RTS_STATIC_ASSERT(offsetof(rts_buffer_t, size) == 4);
RTS_STATIC_ASSERT(offsetof(rts_buffer_t, type_id) == 8);
RTS_STATIC_ASSERT(offsetof(rts_buffer_t, encoding) == 24);
RTS_STATIC_ASSERT(offsetof(rts_buffer_t, data) == 32);
RTS_STATIC_ASSERT(offsetof(rts_buffer_t, len) == 40);
RTS_STATIC_ASSERT(sizeof(rts_loan_t) == 32);
RTS_STATIC_ASSERT(offsetof(rts_loan_t, abi_version) == 0);
RTS_STATIC_ASSERT(offsetof(rts_loan_t, size) == 4);
RTS_STATIC_ASSERT(offsetof(rts_loan_t, token) == 8);
RTS_STATIC_ASSERT(offsetof(rts_loan_t, data) == 16);
RTS_STATIC_ASSERT(offsetof(rts_loan_t, len) == 24);
RTS_STATIC_ASSERT(sizeof(rts_port_t) == 48);
RTS_STATIC_ASSERT(offsetof(rts_port_t, abi_version) == 0);
RTS_STATIC_ASSERT(offsetof(rts_port_t, size) == 4);
RTS_STATIC_ASSERT(offsetof(rts_port_t, name) == 8);
RTS_STATIC_ASSERT(offsetof(rts_port_t, type_id) == 24);
RTS_STATIC_ASSERT(offsetof(rts_port_t, direction) == 40);
RTS_STATIC_ASSERT(sizeof(rts_service_t) == 64);
RTS_STATIC_ASSERT(offsetof(rts_service_t, abi_version) == 0);
RTS_STATIC_ASSERT(offsetof(rts_service_t, size) == 4);
RTS_STATIC_ASSERT(offsetof(rts_service_t, port) == 8);
RTS_STATIC_ASSERT(offsetof(rts_service_t, name) == 24);
RTS_STATIC_ASSERT(offsetof(rts_service_t, interface_id) == 40);
RTS_STATIC_ASSERT(offsetof(rts_service_t, polarity) == 56);
RTS_STATIC_ASSERT(sizeof(rts_parameter_t) == 104);
RTS_STATIC_ASSERT(offsetof(rts_parameter_t, abi_version) == 0);
RTS_STATIC_ASSERT(offsetof(rts_parameter_t, size) == 4);
RTS_STATIC_ASSERT(offsetof(rts_parameter_t, name) == 8);
RTS_STATIC_ASSERT(offsetof(rts_parameter_t, default_value) == 24);
RTS_STATIC_ASSERT(offsetof(rts_parameter_t, value_type) == 40);
RTS_STATIC_ASSERT(offsetof(rts_parameter_t, unit) == 56);
RTS_STATIC_ASSERT(offsetof(rts_parameter_t, constraint) == 72);
RTS_STATIC_ASSERT(offsetof(rts_parameter_t, description) == 88);
RTS_STATIC_ASSERT(sizeof(rts_module_t) == 208);
RTS_STATIC_ASSERT(offsetof(rts_module_t, abi_version) == 0);
RTS_STATIC_ASSERT(offsetof(rts_module_t, size) == 4);
RTS_STATIC_ASSERT(offsetof(rts_module_t, type_name) == 8);
RTS_STATIC_ASSERT(offsetof(rts_module_t, vendor) == 24);
RTS_STATIC_ASSERT(offsetof(rts_module_t, category) == 40);
RTS_STATIC_ASSERT(offsetof(rts_module_t, version) == 56);
RTS_STATIC_ASSERT(offsetof(rts_module_t, description) == 72);
RTS_STATIC_ASSERT(offsetof(rts_module_t, idl) == 88);
RTS_STATIC_ASSERT(offsetof(rts_module_t, default_rate) == 104);
RTS_STATIC_ASSERT(offsetof(rts_module_t, execution_kind) == 112);
RTS_STATIC_ASSERT(offsetof(rts_module_t, activity_type) == 116);
RTS_STATIC_ASSERT(offsetof(rts_module_t, max_instances) == 120);
RTS_STATIC_ASSERT(offsetof(rts_module_t, actions) == 124);
RTS_STATIC_ASSERT(offsetof(rts_module_t, ports) == 128);
RTS_STATIC_ASSERT(offsetof(rts_module_t, ports_len) == 136);
RTS_STATIC_ASSERT(offsetof(rts_module_t, parameters) == 144);
RTS_STATIC_ASSERT(offsetof(rts_module_t, parameters_len) == 152);
RTS_STATIC_ASSERT(offsetof(rts_module_t, services) == 160);
RTS_STATIC_ASSERT(offsetof(rts_module_t, services_len) == 168);
RTS_STATIC_ASSERT(offsetof(rts_module_t, create) == 176);
RTS_STATIC_ASSERT(offsetof(rts_module_t, destroy) == 184);
RTS_STATIC_ASSERT(offsetof(rts_module_t, callback) == 192);
RTS_STATIC_ASSERT(offsetof(rts_module_t, configure) == 200);
RTS_STATIC_ASSERT(sizeof(rts_host_t) == 104);
RTS_STATIC_ASSERT(offsetof(rts_host_t, abi_version) == 0);
RTS_STATIC_ASSERT(offsetof(rts_host_t, size) == 4);
RTS_STATIC_ASSERT(offsetof(rts_host_t, context) == 8);
RTS_STATIC_ASSERT(offsetof(rts_host_t, log) == 16);
RTS_STATIC_ASSERT(offsetof(rts_host_t, fail) == 24);
RTS_STATIC_ASSERT(offsetof(rts_host_t, now) == 32);
RTS_STATIC_ASSERT(offsetof(rts_host_t, rate) == 40);
RTS_STATIC_ASSERT(offsetof(rts_host_t, wake) == 48);
RTS_STATIC_ASSERT(offsetof(rts_host_t, write) == 56);
RTS_STATIC_ASSERT(offsetof(rts_host_t, read) == 64);
RTS_STATIC_ASSERT(offsetof(rts_host_t, is_new) == 72);
RTS_STATIC_ASSERT(offsetof(rts_host_t, loan) == 80);
RTS_STATIC_ASSERT(offsetof(rts_host_t, publish) == 88);
RTS_STATIC_ASSERT(offsetof(rts_host_t, discard) == 96);
#endif

#endif  /* RTSCTL_RTS_MODULE_H */
