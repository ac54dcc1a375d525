// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/export/fmu.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdint>

#include "ident/export/model_formats.hpp"

namespace eha::ident {
namespace {

constexpr const char* kInterface =
    R"(/* FMI 2.0 for co-simulation: u in, y out; the input is held over a communication step. */
#include <stdlib.h>
#include <string.h>

# include "fmi2Functions.h"
# include "@F@.c"

typedef struct {
  @F@_model model;
  double input;
  double output;  /* at the present time */
  double step_s;  /* of the matrices; 0: none yet */
} @F@_instance;

#define UNUSED(x) ((void)(x))

static void @F@_clear(@F@_instance *c) {
  memset(c, 0, sizeof *c);
  /* Any step gives the states at the start, and with them the first output. */
  if (@F@_init(&c->model, 1.0 + @F@_delay_s) == 0) {
    int s;
    c->output = @F@_initial_output;
    for (s = 0; s < @F@_count; ++s) c->output += c->model.x[s][0];
  }
}

/* The output of the next row, before its input: what @F@_step would give. */
static double @F@_output(const @F@_model *model) {
  double output = @F@_initial_output + @F@_direct * model->past[(model->at + 1) % model->length];
  int s;
  for (s = 0; s < @F@_count; ++s) output += model->x[s][0];
  return output;
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
  UNUSED(c); UNUSED(on); UNUSED(n); UNUSED(categories);
  return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging) {
  @F@_instance *c;
  UNUSED(resources); UNUSED(functions); UNUSED(visible); UNUSED(logging);
  if (name == NULL || name[0] == '\0' || type != fmi2CoSimulation || guid == NULL || strcmp(guid, "@GUID@") != 0) return NULL;
  c = (@F@_instance *)malloc(sizeof *c);
  if (c != NULL) @F@_clear(c);
  return c;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop) {
  UNUSED(c); UNUSED(has_tolerance); UNUSED(tolerance); UNUSED(start); UNUSED(has_stop); UNUSED(stop);
  return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) { UNUSED(c); return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { UNUSED(c); return fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component c) { UNUSED(c); return fmi2OK; }

fmi2Status fmi2Reset(fmi2Component c) {
  @F@_clear((@F@_instance *)c);
  return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
  const @F@_instance *c = (const @F@_instance *)component;
  size_t i;
  for (i = 0; i < n; ++i) {
    if (vr[i] > 1) return fmi2Error;
    value[i] = vr[i] == 0 ? c->input : c->output;
  }
  return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
  @F@_instance *c = (@F@_instance *)component;
  size_t i;
  for (i = 0; i < n; ++i) {
    if (vr[i] != 0) return fmi2Error;
    c->input = value[i];
  }
  return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real step_s, fmi2Boolean no_set_state) {
  @F@_instance *c = (@F@_instance *)component;
  UNUSED(time); UNUSED(no_set_state);
  if (!(step_s > 0.0)) return fmi2Error;
  if (!(step_s >= c->step_s && step_s <= c->step_s)) {
    @F@_model before = c->model;
    const int is_first = c->step_s <= 0.0;
    if (!is_first && @F@_delay_s > 0.0) return fmi2Error;
    if (@F@_init(&c->model, step_s) != 0) return fmi2Error;
    if (!is_first) {
      memcpy(c->model.x, before.x, sizeof before.x);
      memcpy(c->model.past, before.past, sizeof before.past);
      c->model.at = before.at;
    }
    c->step_s = step_s;
  }
  (void)@F@_step(&c->model, c->input);
  c->output = @F@_output(&c->model);
  return fmi2OK;
}

#define NO_VALUES(Name, Type) \
  fmi2Status fmi2Get##Name(fmi2Component c, const fmi2ValueReference vr[], size_t n, Type value[]) { \
    UNUSED(c); UNUSED(vr); UNUSED(value); \
    return n == 0 ? fmi2OK : fmi2Error; \
  } \
  fmi2Status fmi2Set##Name(fmi2Component c, const fmi2ValueReference vr[], size_t n, const Type value[]) { \
    UNUSED(c); UNUSED(vr); UNUSED(value); \
    return n == 0 ? fmi2OK : fmi2Error; \
  }
NO_VALUES(Integer, fmi2Integer)
NO_VALUES(Boolean, fmi2Boolean)
NO_VALUES(String, fmi2String)

/* What the description declares as absent. */
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *s) { UNUSED(c); UNUSED(s); return fmi2Error; }
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate s) { UNUSED(c); UNUSED(s); return fmi2Error; }
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *s) { UNUSED(c); UNUSED(s); return fmi2Error; }
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate s, size_t *n) { UNUSED(c); UNUSED(s); UNUSED(n); return fmi2Error; }
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n) { UNUSED(c); UNUSED(s); UNUSED(b); UNUSED(n); return fmi2Error; }
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s) { UNUSED(c); UNUSED(b); UNUSED(n); UNUSED(s); return fmi2Error; }
fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference z[], size_t nz, const fmi2ValueReference v[],
                                        size_t nv, const fmi2Real dv[], fmi2Real dz[]) {
  UNUSED(c); UNUSED(z); UNUSED(nz); UNUSED(v); UNUSED(nv); UNUSED(dv); UNUSED(dz);
  return fmi2Error;
}
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                                       const fmi2Real value[]) {
  UNUSED(c); UNUSED(vr); UNUSED(order); UNUSED(value);
  return n == 0 ? fmi2OK : fmi2Error;
}
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                                        fmi2Real value[]) {
  UNUSED(c); UNUSED(vr); UNUSED(order); UNUSED(value);
  return n == 0 ? fmi2OK : fmi2Error;
}
fmi2Status fmi2CancelStep(fmi2Component c) { UNUSED(c); return fmi2Error; }
fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind k, fmi2Status *v) { UNUSED(c); UNUSED(k); UNUSED(v); return fmi2Discard; }
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind k, fmi2Real *v) { UNUSED(c); UNUSED(k); UNUSED(v); return fmi2Discard; }
fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind k, fmi2Integer *v) { UNUSED(c); UNUSED(k); UNUSED(v); return fmi2Discard; }
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind k, fmi2Boolean *v) { UNUSED(c); UNUSED(k); UNUSED(v); return fmi2Discard; }
fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind k, fmi2String *v) { UNUSED(c); UNUSED(k); UNUSED(v); return fmi2Discard; }

/* Model exchange: present, so that the tools that look for them find them. */
fmi2Status fmi2EnterEventMode(fmi2Component c) { UNUSED(c); return fmi2Error; }
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *e) { UNUSED(c); UNUSED(e); return fmi2Error; }
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) { UNUSED(c); return fmi2Error; }
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean n, fmi2Boolean *e, fmi2Boolean *t) { UNUSED(c); UNUSED(n); UNUSED(e); UNUSED(t); return fmi2Error; }
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t) { UNUSED(c); UNUSED(t); return fmi2Error; }
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) { UNUSED(c); UNUSED(x); UNUSED(n); return fmi2Error; }
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real x[], size_t n) { UNUSED(c); UNUSED(x); UNUSED(n); return fmi2Error; }
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real x[], size_t n) { UNUSED(c); UNUSED(x); UNUSED(n); return fmi2Error; }
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) { UNUSED(c); UNUSED(x); UNUSED(n); return fmi2Error; }
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n) { UNUSED(c); UNUSED(x); UNUSED(n); return fmi2Error; }
)";

constexpr const char* kDescription = R"(<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="@F@" guid="@GUID@" generationTool="eha" variableNamingConvention="flat">
  <CoSimulation modelIdentifier="@F@" canHandleVariableCommunicationStepSize="@VARIABLE@">
    <SourceFiles>
      <File name="fmu.c"/>
    </SourceFiles>
  </CoSimulation>
  <UnitDefinitions>
    <Unit name="@IN@"/>
@OUT_UNIT@  </UnitDefinitions>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input" variability="continuous" description="input, held over a step">
      <Real start="0" unit="@IN@"/>
    </ScalarVariable>
    <ScalarVariable name="y" valueReference="1" causality="output" variability="continuous" initial="calculated" description="output">
      <Real unit="@OUT@"/>
    </ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs>
      <Unknown index="2" dependencies=""/>
    </Outputs>
    <InitialUnknowns>
      <Unknown index="2" dependencies=""/>
    </InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
)";

/// A unit for XML: letters, digits and the marks of units; anything else becomes '?'.
std::string plain_unit(const std::string& unit) {
  std::string result = unit.substr(0, 20);
  for (char& c : result) {
    const bool is_word = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
    if (!is_word && std::string_view("/^.%*-_").find(c) == std::string_view::npos) c = '?';
  }
  return result.empty() ? "1" : result;
}

std::string replaced(std::string text, std::string_view token, std::string_view by) {
  for (std::size_t at = 0; (at = text.find(token, at)) != std::string::npos; at += by.size()) {
    text.replace(at, token.size(), by);
  }
  return text;
}

/// FNV-1a, twice with other offsets: the unit's identity follows from its sources.
std::string identity(std::string_view text) {
  std::string digits;
  for (std::uint64_t hash : {14695981039346656037ULL, 1099511628211ULL * 31ULL}) {
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
    digits += fmt::format("{:016x}", hash);
  }
  return fmt::format("{{{}-{}-{}-{}-{}}}", digits.substr(0, 8), digits.substr(8, 4), digits.substr(12, 4),
                     digits.substr(16, 4), digits.substr(20, 12));
}

std::uint32_t crc32(std::string_view bytes) {
  std::uint32_t crc = 0xffffffffU;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int i = 0; i < 8; ++i) crc = (crc >> 1U) ^ (0xedb88320U & (0U - (crc & 1U)));
  }
  return ~crc;
}

void put(std::string& bytes, std::uint64_t value, int count) {
  for (int i = 0; i < count; ++i) bytes += static_cast<char>((value >> (8 * i)) & 0xffU);
}

constexpr std::uint32_t kVersion = 20;      // stored files in folders
constexpr std::uint32_t kFirstDate = 0x21;  // 1980-01-01

/// Fields that a local header and an entry of the directory share.
void put_facts(std::string& bytes, const ArchivedFile& file) {
  put(bytes, kVersion, 2);
  put(bytes, 0, 2);  // flags
  put(bytes, 0, 2);  // stored
  put(bytes, 0, 2);  // time
  put(bytes, kFirstDate, 2);
  put(bytes, crc32(file.content), 4);
  put(bytes, file.content.size(), 4);
  put(bytes, file.content.size(), 4);
  put(bytes, file.name.size(), 2);
  put(bytes, 0, 2);  // extra
}

}  // namespace

std::string zip_bytes(const std::vector<ArchivedFile>& files) {
  // APPNOTE.TXT of PKWARE, 4.3.
  std::string bytes;
  std::string directory;
  for (const ArchivedFile& file : files) {
    put(directory, 0x02014b50U, 4);
    put(directory, kVersion, 2);
    put_facts(directory, file);
    put(directory, 0, 2);  // comment
    put(directory, 0, 2);  // disk
    put(directory, 0, 2);
    put(directory, 0, 4);
    put(directory, bytes.size(), 4);
    directory += file.name;
    put(bytes, 0x04034b50U, 4);
    put_facts(bytes, file);
    bytes += file.name + file.content;
  }
  const std::size_t start = bytes.size();
  bytes += directory;
  put(bytes, 0x06054b50U, 4);
  put(bytes, 0, 4);
  put(bytes, files.size(), 2);
  put(bytes, files.size(), 2);
  put(bytes, directory.size(), 4);
  put(bytes, start, 4);
  put(bytes, 0, 2);
  return bytes;
}

std::vector<ArchivedFile> fmu_files(const ExportedModel& model, const std::string& function) {
  const std::string source = c_text(model, function);
  const std::string guid = identity(source);
  const auto named = [&](std::string text) {
    return replaced(replaced(std::move(text), "@F@", function), "@GUID@", guid);
  };
  const std::string in = plain_unit(model.input_unit);
  const std::string out = plain_unit(model.output_unit);
  std::string description = named(kDescription);
  description = replaced(description, "@VARIABLE@", model.sections.delay_s > 0.0 ? "false" : "true");
  description = replaced(description, "@OUT_UNIT@", out == in ? "" : "    <Unit name=\"" + out + "\"/>\n");
  description = replaced(replaced(description, "@IN@", in), "@OUT@", out);
  std::vector<ArchivedFile> files{{"modelDescription.xml", description},
                                  {"sources/fmu.c", named(kInterface)},
                                  {"sources/" + function + ".c", source}};
  for (ArchivedFile& header : fmi_headers()) files.push_back({"sources/" + header.name, std::move(header.content)});
  return files;
}

std::string fmu_bytes(const ExportedModel& model, const std::string& function) {
  return zip_bytes(fmu_files(model, function));
}

}  // namespace eha::ident
