/* Multiplies what it reads by a factor: a component in plain C, which a C++11 compiler takes as well.
 *
 *   cc -shared -fPIC -I agent/runtime/include -o libscale.so manifests/components_c/scale/scale.c
 */

#include <rtsctl/rts_module.h>

#include <stdio.h>
#include <stdlib.h>

#define TIMED_DOUBLE "IDL:RTC/TimedDouble:1.0"

enum { IN = 0, OUT = 1 };

/* RTC::TimedDouble in little endian CDR, as this machine has it in memory. */
typedef struct {
  uint32_t sec;
  uint32_t nsec;
  double data;
} timed_double_t;

RTS_STATIC_ASSERT(sizeof(timed_double_t) == 16);

typedef struct {
  const rts_host_t *host;
  double factor;
  unsigned long scaled;
  double last;
} scale_t;

static int32_t create(const rts_host_t *host, void **instance) {
  scale_t *self;
  /* Version and size come first in every version: look at them before anything else. Not at sizeof(rts_host_t), which a
     later header makes larger: the last function that is used here is publish. */
  if (host->abi_version != RTS_ABI_VERSION || !RTS_HAS(rts_host_t, host, publish)) {
    return RTS_UNSUPPORTED;
  }
  self = (scale_t *)calloc(1, sizeof(scale_t));
  if (self == NULL) {
    return RTS_OUT_OF_RESOURCES;
  }
  self->host = host;
  self->factor = 2.0;
  *instance = self;
  return RTS_OK;
}

static void destroy(void *instance) { free(instance); }

/* The manager has checked type and constraint; what is left is to read it. */
static int32_t configure(void *instance, rts_text_t name, rts_text_t value) {
  scale_t *self = (scale_t *)instance;
  char text[64];
  char *end;
  double factor;
  (void)name; /* There is but one. */
  if (value.len >= sizeof(text)) {
    return RTS_BAD_PARAMETER;
  }
  memcpy(text, value.data, value.len);
  text[value.len] = 0;
  factor = strtod(text, &end);
  if (end == text) {
    self->host->fail(self->host->context, rts_text("it is no number"));
    return RTS_BAD_PARAMETER;
  }
  self->factor = factor;
  return RTS_OK;
}

static int32_t execute(scale_t *self) {
  const rts_host_t *host = self->host;
  rts_buffer_t in;
  in.abi_version = RTS_ABI_VERSION;
  in.size = sizeof(in);
  while (host->read(host->context, IN, &in) == RTS_PORT_OK) {
    timed_double_t sample;
    rts_loan_t out;
    if (in.len != sizeof(sample)) {
      host->fail(host->context, rts_text("a sample is no TimedDouble"));
      return RTS_ERROR;
    }
    memcpy(&sample, in.data, sizeof(sample));
    sample.data *= self->factor;
    self->scaled += 1;
    self->last = sample.data;
    out.abi_version = RTS_ABI_VERSION;
    out.size = sizeof(out);
    /* Written in place: the manager sends these very bytes. */
    if (host->loan(host->context, OUT, sizeof(sample), &out) == RTS_PORT_OK) {
      memcpy(out.data, &sample, sizeof(sample));
      host->publish(host->context, out.token, sizeof(sample));
    }
  }
  return RTS_OK;
}

static int32_t callback(void *instance, uint32_t number) {
  scale_t *self = (scale_t *)instance;
  char line[96];
  switch (number) {
    case RTS_ON_EXECUTE:
      return execute(self);
    case RTS_ON_DEACTIVATED:
      snprintf(line, sizeof(line), "scaled %lu samples, the last to %g", self->scaled, self->last);
      self->host->log(self->host->context, 2, rts_text(line));
      return RTS_OK;
    default:
      return RTS_NOT_IMPLEMENTED;
  }
}

static rts_port_t port(const char *name, uint32_t direction) {
  rts_port_t made;
  memset(&made, 0, sizeof(made));
  made.abi_version = RTS_ABI_VERSION;
  made.size = sizeof(made);
  made.name = rts_text(name);
  made.type_id = rts_text(TIMED_DOUBLE);
  made.direction = direction;
  return made;
}

/* Filled at the first call; managers open one module at a time. */
static rts_module_t module;
static rts_port_t ports[2];
static rts_parameter_t parameters[1];

RTS_EXPORT const rts_module_t *rts_module_v1(void) {
  ports[IN] = port("in", RTS_PORT_IN);
  ports[OUT] = port("out", RTS_PORT_OUT);

  parameters[0].abi_version = RTS_ABI_VERSION;
  parameters[0].size = sizeof(parameters[0]);
  parameters[0].name = rts_text("factor");
  parameters[0].default_value = rts_text("2.0");
  parameters[0].value_type = rts_text("double");
  parameters[0].constraint = rts_text("-1000<=x<=1000");
  parameters[0].description = rts_text("what each sample is multiplied by");

  module.abi_version = RTS_ABI_VERSION;
  module.size = sizeof(module);
  module.type_name = rts_text("Scale");
  module.vendor = rts_text("rtsctl");
  module.category = rts_text("example");
  module.version = rts_text("1.0.0");
  module.description = rts_text("multiplies by a factor, in C");
  module.default_rate = 100.0;
  module.execution_kind = RTS_EXECUTION_PERIODIC;
  module.activity_type = RTS_ACTIVITY_PERIODIC;
  module.actions = 1u << RTS_ON_EXECUTE | 1u << RTS_ON_DEACTIVATED;
  module.ports = ports;
  module.ports_len = 2;
  module.parameters = parameters;
  module.parameters_len = 1;
  module.create = create;
  module.destroy = destroy;
  module.callback = callback;
  module.configure = configure;
  return &module;
}
