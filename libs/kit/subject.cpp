#include "kit/subject.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "kinome/error.h"

namespace kinome::check {
namespace {

namespace fs = std::filesystem;

std::string escaped(const std::string& text) {
  std::string xml;
  for (const char c : text) {
    xml += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string(1, c);
  }
  return xml;
}

/// Returns true if the value consists of several numbers.
bool is_vector(const std::string& value) {
  return value.find_first_of(" ,") != std::string::npos;
}

bool is_number(const std::string& value) {
  char* end = nullptr;
  std::strtod(value.c_str(), &end);
  return !value.empty() && *end == 0;
}

const Parameter* row_of(const PluginDescriptor& plugin, const std::string& name) {
  for (const Parameter& row : plugin.parameters) {
    if (row.name == name) return &row;
  }
  return nullptr;
}

const char* tag_of(const Parameter& parameter, const std::string& value) {
  if (parameter.type == ParameterType::kFloatOrName && !is_number(value)) return "string";
  if (takes_texture(parameter.type) && is_vector(value)) return "rgb";
  return values_of(parameter.type).tag;
}

/// Camera for the scenes of the checks.
constexpr const char* kCamera =
    "<sensor type='perspective'><float name='fov' value='60'/><transform name='to_world'>"
    "<lookat origin='0 -4 2.5' target='0 0 0.3' up='0 0 1'/></transform>"
    "<sampler type='independent'/><film type='hdrfilm'><integer name='width' value='64'/>"
    "<integer name='height' value='64'/><rfilter type='box'/></film></sensor>";

/// Returns the XML element of a nested object, with the name that the parameter requires.
std::string named_xml(const Parameter& parameter, std::string element) {
  if (!parameter.by_name) return element;
  return element.insert(element.find(" type="),
                        fmt::format(" name=\"{}\"", escaped(parameter.name)));
}

const char* object_xml(Category category) {
  switch (category) {
    case Category::kBsdf: return "<bsdf type=\"diffuse\"/>";
    case Category::kEmitter: return "<emitter type=\"area\"/>";
    case Category::kFilm: return "<film type=\"hdrfilm\"/>";
    case Category::kIntegrator: return "<integrator type=\"direct\"/>";
    case Category::kMedium: return "<medium type=\"homogeneous\"/>";
    case Category::kPhase: return "<phase type=\"isotropic\"/>";
    case Category::kReconstructionFilter: return "<rfilter type=\"box\"/>";
    case Category::kSampler: return "<sampler type=\"independent\"/>";
    case Category::kSensor: return kCamera;
    case Category::kShape: return "<shape type=\"sphere\"/>";
    case Category::kTexture: return "<texture type=\"checkerboard\"/>";
    case Category::kVolume: return "<volume type=\"constvolume\"/>";
  }
  return "";
}

}  // namespace

TypeValues values_of(ParameterType type) {
  const std::vector<std::string> numbers = {"0",      "1",    "-1",    "0.5",  "1e-10",
                                            "-1e-10", "1e10", "-1e10", "1e30", "-1e30"};
  switch (type) {
    case ParameterType::kBoolean:
      return {"boolean", "false", {"true", "false"}, {"true", "false"}, {"maybe", ""}};
    case ParameterType::kInteger:
      return {"integer",
              "1",
              {"1", "2", "7"},
              {"0", "1", "-1", "2", "1000003", "2147483647", "-2147483648"},
              {"1.5", "one", "", "99999999999999999999"}};
    case ParameterType::kFloat:
      return {"float", "0.5", {"0.5", "1", "2"}, numbers, {"nan", "one", "", "1 2"}};
    case ParameterType::kFloatOrName:
      return {"float", "0.5", {"0.5", "1", "2"}, numbers, {"there is no such thing"}};
    case ParameterType::kString:
      return {"string", "", {}, {"", "there is no such thing", "0"}, {}};
    case ParameterType::kFile:
      return {"string", "", {}, {}, {"", "no/such/file", "/", "/dev/null"}};
    case ParameterType::kVector:
      return {"vector",
              "0.5",
              {"0, 0, 1", "1, 0, 0"},
              {"0, 0, 0", "1, 0, 0", "0, 0, -1", "1e10, 1e10, 1e10", "1e-10, 0, 0"},
              {"1 2", "nan, 0, 0", "up"}};
    case ParameterType::kEmission:
    case ParameterType::kEmissionTexture:
    case ParameterType::kReflectanceTexture:
    case ParameterType::kUnitlessTexture:
    case ParameterType::kColorTexture:
    case ParameterType::kVolume: {
      TypeValues values{"float", "0.5", {"0.5", "1", "2"}, numbers, {"nan", "red", "1, 2"}};
      values.extreme.insert(values.extreme.end(), {"0, 0.5, 1", "1e10, 0, 0"});
      return values;
    }
    case ParameterType::kTransform:
      return {"transform",
              "",
              {"identity"},
              {"1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1", "0 1 0 3  1 0 0 4  0 0 1 5  0 0 0 1",
               "1e5 0 0 0  0 1e5 0 0  0 0 1e5 0  0 0 0 1", "2 1 0 0  0 -1 0 0  0 0 1 1e4  0 0 0 1",
               "0 0 0 0  0 0 0 0  0 0 0 0  0 0 0 1"},
              {"1 2 3", "nan"}};
    case ParameterType::kImage:
    case ParameterType::kObject:
      break;
  }
  return {};
}

std::string parameter_xml(const Parameter& parameter, const std::string& value) {
  if (value.starts_with('<')) return value;
  const std::string name = escaped(parameter.name), text = escaped(value);
  if (parameter.type == ParameterType::kTransform) {
    if (value == "identity") return fmt::format("<transform name=\"{}\"></transform>", name);
    return fmt::format("<transform name=\"{}\"><matrix value=\"{}\"/></transform>", name, text);
  }
  if (parameter.type == ParameterType::kObject) {
    return named_xml(parameter,
                     fmt::format("<{} type=\"{}\"/>", to_string(parameter.category), text));
  }
  return fmt::format("<{} name=\"{}\" value=\"{}\"/>", tag_of(parameter, value), name, text);
}

std::string needed_xml(const Parameter& parameter) {
  if (parameter.type == ParameterType::kObject) {
    return named_xml(parameter, object_xml(parameter.category));
  }
  const std::string needed = values_of(parameter.type).needed;
  return needed.empty() ? "" : parameter_xml(parameter, needed);
}

Subject::Subject(const Request& request) : request_(request) {
  std::string wanted = request.plugin;
  std::vector<std::string> paths = request.plugin_paths;
  if (wanted.ends_with(".so")) {
    const fs::path path = fs::absolute(wanted);
    const std::string category = path.parent_path().filename().string();
    if (!category_named(category)) {
      throw Error(
          fmt::format("'{}': expected PLUGINS/CATEGORY/NAME.so, as built by "
                      "kinome_add_plugin()",
                      wanted));
    }
    if (!fs::exists(path)) throw Error(fmt::format("'{}': no such file", wanted));
    paths.insert(paths.begin(), path.parent_path().parent_path().string());
    wanted = category + "/" + path.stem().string();
  }
  folders_ = PluginRegistry::default_folders(paths);
  registry_ = std::make_unique<PluginRegistry>(folders_, choose_instruction_set(request.isa));
  find(wanted);
  plugin_ = &registry_->find(category_, name_);
  for (const auto& [name, value] : request.parameters) {
    if (value.starts_with('<') || row_of(*plugin_, name)) continue;
    std::vector<std::string> names;
    for (const Parameter& parameter : plugin_->parameters) names.emplace_back(parameter.name);
    throw Error(fmt::format("-D: {} has no parameter '{}'{}", title(), name,
                            did_you_mean(nearest_name(name, names))));
  }
  if (!request.against.empty()) read_against();
  for (const Parameter& parameter : plugin_->parameters) {
    if (parameter.required && !is_given(parameter) &&
        needed_xml(parameter).empty()) {
      throw Error(fmt::format("{} needs a value for '{}': add -D {}=…", title(), parameter.name,
                              parameter.name));
    }
  }
}

void Subject::read_against() {
  if (category_ != Category::kIntegrator && category_ != Category::kEmitter) {
    throw Error(fmt::format("--against: {} is neither an integrator nor an emitter", title()));
  }
  try {
    const auto other = load(xml_against());
    if (!other->plugin().starts_with(std::string(to_string(category_)) + "/")) {
      throw Error(fmt::format("{} can't be compared with {}", title(), other->plugin()));
    }
  } catch (const Error& error) {
    throw Error("--against: " + error.message());
  }
}

std::string Subject::xml_against() const {
  if (request_.against.starts_with('<')) return request_.against;
  const PluginDescriptor& other = registry_->find(category_, request_.against);
  std::string text =
      fmt::format("<{} type=\"{}\">", to_string(category_), escaped(request_.against));
  for (const auto& [name, value] : request_.parameters) {
    if (const Parameter* const row = row_of(other, name)) {
      text += '\n' + parameter_xml(*row, value);
    }
  }
  return text + fmt::format("</{}>", to_string(category_));
}

void Subject::find(const std::string& wanted) {
  std::vector<std::string> found, known;
  for (const Category category : kCategories) {
    for (const std::string& name : registry_->names(category)) {
      const std::string full = std::string(to_string(category)) + "/" + name;
      known.push_back(name);
      if (wanted != name && wanted != full) continue;
      found.push_back(full);
      category_ = category;
      name_ = name;
    }
  }
  if (found.size() == 1) return;
  if (found.size() > 1) {
    throw Error(fmt::format("'{}' is ambiguous: write {} or {}", wanted, found[0], found[1]));
  }
  const std::string near = nearest_name(wanted, known);
  throw Error(
      fmt::format("unknown plugin '{}'{}", wanted,
                  near.empty() ? "; `kinome plugins` lists all plugins" : did_you_mean(near)));
}

int Subject::samples(int usual) const {
  return std::max(100, static_cast<int>(usual * request_.effort));
}

bool Subject::is_given(const Parameter& parameter) const {
  const std::string tag = std::string("<") + to_string(parameter.category);
  return request_.parameters.count(parameter.name) > 0 ||
         (parameter.type == ParameterType::kObject && !parameter.by_name &&
          std::any_of(request_.parameters.begin(), request_.parameters.end(),
                      [&](const auto& given) { return given.second.starts_with(tag); }));
}

std::string Subject::xml(const std::string& more, const std::string& changed,
                         const std::string& value_xml) const {
  std::string text = fmt::format("<{} type=\"{}\">", to_string(category_), name_);
  for (const auto& [name, value] : request_.parameters) {
    if (name == changed) continue;
    const Parameter* const row = row_of(*plugin_, name);
    text += '\n' + (row ? parameter_xml(*row, value) : value);
  }
  if (!request_.parameters.empty()) text += '\n';
  for (const Parameter& parameter : plugin_->parameters) {
    if (!parameter.required || parameter.name == changed) continue;
    // Plugins that need several BSDFs or phase functions get two.
    const bool is_of_two =
        parameter.type == ParameterType::kObject &&
        (parameter.category == Category::kBsdf || parameter.category == Category::kPhase);
    const int count = is_of_two ? std::min(parameter.max_count, 2) : 1;
    for (int i = 0; i < count && !is_given(parameter); ++i) {
      text += needed_xml(parameter);
    }
  }
  return text + value_xml + more + fmt::format("</{}>", to_string(category_));
}

std::unique_ptr<Scene> Subject::scene(const std::string& elements) const {
  return scene_of("<integrator type=\"direct\"/>" + std::string(kCamera) + elements);
}

std::unique_ptr<Scene> Subject::scene_of(const std::string& elements) const {
  LoadOptions options;
  options.threads = 1;
  return load_scene_from_string("<scene version=\"3.0.0\">" + elements + "</scene>", kFile, options,
                                *registry_);
}

}  // namespace kinome::check
