#include "probe.h"

#include "kinome/bsdf.h"
#include "kinome/plugin.h"

/// Stores all parameters that the core passes to a plugin.
namespace kinome {
namespace {

constexpr const char* kChoices[] = {"beckmann", "ggx"};
constexpr Parameter kTable[] = {
    {"boolean", ParameterType::kBoolean, "true", ""},
    {"integer", ParameterType::kInteger, "7", ""},
    {"real", ParameterType::kFloat, "0.25", ""},
    {"string", ParameterType::kString, "text", ""},
    {"file", ParameterType::kFile, nullptr, ""},
    {"vector", ParameterType::kVector, "1 2 3", ""},
    {"color", ParameterType::kEmission, "4 5 6", ""},
    {"transform", ParameterType::kTransform, nullptr, ""},
    {"texture", ParameterType::kReflectanceTexture, "0.5", ""},
    {"unbounded", ParameterType::kUnitlessTexture, "2", ""},
    {"lamp", ParameterType::kEmissionTexture, "1", ""},
    {"optional", ParameterType::kReflectanceTexture, nullptr, ""},
    choice_of("choice", kChoices, "beckmann", ""),
    {"unread", ParameterType::kFloat, "0", "which the plugin never asks for"},
    {"broken", ParameterType::kBoolean, "false", "makes the constructor throw"},
    {"bsdf", ParameterType::kObject, nullptr, "", false, Category::kBsdf, 2},
};

class ProbeTexture final : public test::Probe {
 public:
  explicit ProbeTexture(const Properties& props) {
    boolean = props.boolean("boolean");
    integer = props.integer("integer");
    real = props.real("real");
    string = props.string("string");
    if (props.has("file")) file = props.file("file");
    vector = props.vector("vector");
    color = props.color("color");
    transform = props.transform("transform");
    texture = props.texture("texture");
    unbounded = props.texture("unbounded");
    lamp = props.texture("lamp");
    optional = props.texture("optional");
    choice = props.choice("choice");
    for (auto& bsdf : props.objects<Bsdf>()) objects.push_back(bsdf);
    if (props.boolean("broken")) throw Error("from deep inside");
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::ProbeTexture, kinome::Category::kTexture, "probe", "A probe.",
              kinome::kTable);
