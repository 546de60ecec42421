#include <gtest/gtest.h>

#include "support/plugins/probe_registry.h"

/// A table of invalid scenes. `^` marks the position that the message must name; it is removed
/// before the scene is parsed. Without `^`, the message names only the file.
namespace kinome::test::scene_errors_test {
namespace {

struct Wrong {
  const char* name;
  const char* xml;
  const char* message;  ///< beginning of the message
  std::map<std::string, std::string> defines = {};
};

/// Children of <scene version="3.0.0"> … </scene>, or the whole text if it begins with '!'.
const Wrong kWrong[] = {
    // Malformed XML
    {"Empty", "!^", "malformed XML: "},
    {"OnlyAComment", "!^<!-- nothing -->", "malformed XML: "},
    {"NotClosed", "!<scene version='3.0.0'><shape type='sphere'^>", "malformed XML: "},
    {"WrongEnd", "!<scene version='3.0.0'>\n</^scen>", "malformed XML: "},
    {"NoQuotes", "!<scene version=^3>\n</scene>", "malformed XML: "},
    {"TwoRoots", "!<scene version='3.0.0'/>\n ^<scene version='3.0.0'/>",
     "malformed XML: a second root element"},
    {"TextBehindTheRoot", "!<scene version='3.0.0'/>\n<!-- a comment --> ^more",
     "malformed XML: text outside of"},
    {"TextBeforeTheRoot", "!^more <scene version='3.0.0'/>", "malformed XML: text outside of"},
    {"PlainText", "!^this is no XML at all", "malformed XML: "},
    {"AttributeTwice", "<bsdf type='diffuse' id='a' ^id='b'/>", "attribute 'id' is given twice"},

    // Version
    {"NoVersion", "!\n  ^<scene/>", "<scene> needs an attribute 'version'"},
    {"MisspeltVersion", "!<scene ^versoin='3.0.0'/>",
     "<scene> has no attribute 'versoin' (did you mean 'version'?)"},
    {"BadVersion", "!<scene ^version='three'/>", "'three' is not a version such as '3.0.0'"},
    {"ShortVersion", "!<scene ^version='3.0'/>", "'3.0' is not a version"},
    {"LongVersion", "!<scene ^version='3.0.0.1'/>", "'3.0.0.1' is not a version"},
    {"RootIsNoScene", "!^<bsdf version='3.0.0' type='diffuse'/>", "the root must be <scene>"},

    // Tags and attributes
    {"UnknownTag", "^<spehre/>", "unknown tag <spehre>"},
    {"UnknownTagSuggests", "^<shap type='sphere'/>", "unknown tag <shap> (did you mean 'shape'?)"},
    {"OldLookAt",
     "<sensor type='perspective'><transform name='to_world'>"
     "^<lookAt origin='1' target='0'/></transform></sensor>",
     "unknown tag <lookAt> (did you mean 'lookat'?)"},
    {"UnknownAttribute", "<shape type='sphere' ^nmae='x'/>",
     "<shape> has no attribute 'nmae' (did you mean 'name'?)"},
    {"NoType", "^<shape/>", "<shape> needs an attribute 'type'"},
    {"NoName", "<bsdf type='diffuse'>\n\t^<float value='1'/></bsdf>",
     "<float> needs an attribute 'name'"},
    {"NoValue", "<bsdf type='diffuse'>^<float name='a'/></bsdf>",
     "<float> needs an attribute 'value'"},
    {"EmptyName", "<bsdf type='diffuse'><float ^name='' value='1'/></bsdf>", "name is empty"},
    {"EmptyRef", "<shape type='sphere'><ref ^id=''/></shape>", "id is empty"},
    {"ReservedName", "<shape type='sphere'><bsdf type='diffuse' ^name='_arg_0'/></shape>",
     "'_arg_0': names that begin with _arg_ or _default_ are reserved"},
    {"ValueInsideValue",
     "<bsdf type='diffuse'><float name='a' value='1'>^<float name='b' "
     "value='1'/></float></bsdf>",
     "<float> can't be inside <float>"},
    {"OperationInsideObject", "<shape type='sphere'>^<translate x='1'/></shape>",
     "<translate> can't be inside <shape>"},
    {"ObjectInsideTransform",
     "<shape type='sphere'><transform name='to_world'>^<bsdf type='diffuse'/></transform></shape>",
     "<bsdf> can't be inside <transform>"},
    {"ChildOfDefault", "<default name='a' value='1'>^<float name='a' value='1'/></default>",
     "<float> can't be inside <default>"},
    {"SceneInsideScene", "^<scene/>", "<scene> can't be inside <scene>"},
    {"UnnamedMedium", "<shape type='sphere'>^<medium type='homogeneous'/></shape>",
     "a medium of shape 'sphere' needs a name (one of interior, exterior)"},
    {"UnnamedVolume", "<medium type='homogeneous'>^<volume type='constvolume'/></medium>",
     "a volume of medium 'homogeneous' needs a name (one of albedo, sigma_t)"},
    {"TwoPhases", "<medium type='homogeneous'><phase type='hg'/>\n^<phase type='hg'/></medium>",
     "medium 'homogeneous' takes at most 1 phase"},
    {"AlbedoAboveOne", "<medium type='homogeneous'>^<float name='albedo' value='1.5'/></medium>",
     "'albedo' must be at most 1, got 1.5"},
    {"AlbedoAboveOneInAVolume",
     "<medium type='heterogeneous'>^<volume type='constvolume' name='albedo'><rgb name='value' "
     "value='.5 2 1'/></volume></medium>",
     "'albedo' must be at most 1, got 2"},
    {"NegativeExtinction", "<medium type='homogeneous'>^<float name='sigma_t' value='-1'/></medium>",
     "'sigma_t' must not be negative, got -1"},
    {"InfiniteExtinction",
     "<medium type='homogeneous'><float name='sigma_t' value='1e30'/>^<float name='scale' "
     "value='1e30'/></medium>",
     "'scale' makes the extinction infinite"},
    {"ExtinctionOfTooManySteps",
     "<medium type='heterogeneous'>^<float name='sigma_t' value='1e8'/></medium>",
     "'sigma_t' times the diagonal of its box must be at most 10000000, got 1732050"},
    {"ColorOfExtinction",
     "<medium type='homogeneous'>^<rgb name='sigma_t' value='1 2 3'/></medium>",
     "'sigma_t' is outside [0,1]: 1 2 3; for other colors use <volume type=\"constvolume\">"},
    {"VolumeOfTexture",
     "<medium type='homogeneous'>^<texture type='checkerboard' name='sigma_t'/></medium>",
     "'sigma_t' must be uniform, got a texture that varies"},
    {"StringForVolume", "<medium type='homogeneous'>^<string name='sigma_t' value='a'/></medium>",
     "'sigma_t' must be a volume, color or float, got a string"},
    {"ForwardPhase", "<phase type='hg'>^<float name='g' value='1'/></phase>",
     "'g' must be greater than -1 and less than 1, got 1"},
    {"OnePhaseToBlend", "^<phase type='blendphase'><float name='weight' value='.5'/><phase "
     "type='hg'/></phase>",
     "phase 'blendphase': 'phase' must be two nested phase functions, got 1"},
    {"TableOfOneValue", "<phase type='tabphase'>^<string name='values' value='1'/></phase>",
     "'values' must be at least two numbers, got 1"},
    {"TableOfWords", "<phase type='tabphase'>^<string name='values' value='1, 2x'/></phase>",
     "'values' must be nonnegative numbers, got '2x'"},
    {"NegativeTable", "<phase type='tabphase'>^<string name='values' value='1 -2'/></phase>",
     "'values' must be nonnegative numbers, got '-2'"},
    {"BlackTable", "<phase type='tabphase'>^<string name='values' value='0 0'/></phase>",
     "'values' must have a positive sum"},
    {"UniformFlakes",
     "<phase type='sggx'>^<volume type='constvolume' name='S'/></phase>",
     "'S' must be a volume of 6 channels, got 1"},

    // Plugins and parameters
    {"UnknownPlugin", "<bsdf ^type='difuse'/>",
     "unknown bsdf plugin 'difuse' (did you mean 'diffuse'?)"},
    {"UnknownPluginOfCategory", "<emitter ^type='diffuse'/>", "unknown emitter plugin 'diffuse'"},
    {"UnknownParameter",
     "<bsdf type='diffuse'>\n\n    ^<rgb name='reflectence' value='.5'/></bsdf>",
     "bsdf 'diffuse' has no parameter 'reflectence' (did you mean 'reflectance'?)"},
    {"WrongType", "<bsdf type='diffuse'>^<string name='reflectance' value='red'/></bsdf>",
     "'reflectance' must be a texture, color or float, got a string"},
    {"FloatForInteger", "<texture type='probe'>^<float name='integer' value='3'/></texture>",
     "'integer' must be an integer, got a float"},
    {"MissingParameter", "^<texture type='strict'/>",
     "texture 'strict' needs parameter 'needed', a string"},
    {"Unread",
     "<texture type='probe' id='t'>^<float name='unread' value='1'/></texture><ref id='t'/>",
     "texture 'probe' has unused parameters: 'unread'"},
    {"UnreadOfScene", "^<float name='x' value='1'/>", "<scene> has unused parameters: 'x'"},
    {"WrongTypeOfScene", "^<float name='embree_use_robust_intersections' value='1'/>",
     "'embree_use_robust_intersections' must be a boolean"},
    {"TwiceOfScene",
     "<integer name='kd_max_depth' value='3'/>\n^<integer name='kd_max_depth' value='4'/>",
     "'kd_max_depth' is given twice (first at scene.xml:1:24)"},
    {"ObjectThatNobodyTakes", "<bsdf type='diffuse'>^<film type='hdrfilm'/></bsdf>",
     "bsdf 'diffuse' takes no film"},
    {"UnnamedTexture", "<bsdf type='diffuse'>^<texture type='probe'/></bsdf>",
     "a texture of bsdf 'diffuse' needs a name (one of reflectance)"},
    {"TextureForColor",
     "<texture type='probe' id='t'>^<texture name='color' type='checkerboard'/></texture>"
     "<ref id='t'/>",
     "'color' must be uniform, got a texture that varies"},
    {"TooManyObjects",
     "<texture type='probe'><bsdf type='diffuse'/><bsdf type='diffuse'/>\n"
     "^<bsdf type='diffuse'/></texture>",
     "texture 'probe' takes at most 2 bsdfs"},
    {"BadChoice",
     "<texture type='probe' id='t'>^<string name='choice' value='gxx'/></texture><ref id='t'/>",
     "'choice' must be one of 'beckmann', 'ggx', got 'gxx' (did you mean 'ggx'?)"},
    {"ReflectanceAboveOne",
     "<bsdf type='diffuse'>^<rgb name='reflectance' value='.5 1.1 0'/></bsdf>",
     "'reflectance' is outside [0,1]: 0.5 1.1 0"},
    {"ReflectanceBelowZero", "<bsdf type='diffuse'>^<float name='reflectance' value='-.5'/></bsdf>",
     "'reflectance' is outside [0,1]: -0.5"},
    {"SpectrumAboveOne", "<bsdf type='diffuse'>^<spectrum name='reflectance' value='2'/></bsdf>",
     "'reflectance' is outside [0,1]: 2 2 2"},
    {"FileMissing",
     "<texture type='probe' id='t'>^<string name='file' value='no/such.png'/></texture><ref "
     "id='t'/>",
     "'file' can't be found: there is no file 'no/such.png'; looked in ."},
    {"TwoIntegrators", "<integrator type='direct'/>\n^<integrator type='direct'/>",
     "a scene has at most one integrator"},
    {"TwoEnvironments", "<emitter type='constant'/>\n^<emitter type='constant'/>",
     "a scene has at most one environment emitter"},
    {"NestedSecondEnvironment",
     "<emitter type='constant'/>\n^<emitter type='vpl'><emitter type='constant'/></emitter>",
     "a scene has at most one environment emitter"},
    {"BounceTwice", "<emitter type='vpl'/>\n^<emitter type='vpl'><emitter type='point'/></emitter>",
     "two emitters represent the bounce of the same emitter, which would count twice: give each "},

    // Numbers
    {"NotANumber", "<bsdf type='diffuse'><float name='reflectance' ^value='1.5x'/></bsdf>",
     "'1.5x' is not a number"},
    {"EmptyNumber", "<bsdf type='diffuse'><float name='reflectance' ^value=''/></bsdf>",
     "'' is not a number"},
    {"Infinity", "<bsdf type='diffuse'><float name='reflectance' ^value='inf'/></bsdf>",
     "'inf' is not a number"},
    {"Nan", "<bsdf type='diffuse'><float name='reflectance' ^value='nan'/></bsdf>",
     "'nan' is not a number"},
    {"BeyondFloat", "<bsdf type='diffuse'><float name='reflectance' ^value='1e39'/></bsdf>",
     "'1e39' is not a number"},
    {"BeyondDouble", "<bsdf type='diffuse'><float name='reflectance' ^value='1e999'/></bsdf>",
     "'1e999' is not a number"},
    {"CommaNumber", "<bsdf type='diffuse'><float name='reflectance' ^value='1,5'/></bsdf>",
     "'1,5' is not a number"},
    {"TwoSigns", "<bsdf type='diffuse'><float name='reflectance' ^value='+-1'/></bsdf>",
     "'+-1' is not a number"},
    {"HexNumber", "<bsdf type='diffuse'><float name='reflectance' ^value='0x1'/></bsdf>",
     "'0x1' is not a number"},
    {"NotAnInteger", "<texture type='probe'><integer name='integer' ^value='1.0'/></texture>",
     "'1.0' is not an integer"},
    {"HugeInteger",
     "<texture type='probe'><integer name='integer' ^value='9223372036854775808'/></texture>",
     "'9223372036854775808' is not an integer"},
    {"NotABoolean", "<texture type='probe'><boolean name='boolean' ^value='yes'/></texture>",
     "'yes' is not true or false"},
    {"TwoColors", "<bsdf type='diffuse'><rgb name='reflectance' ^value='1 2'/></bsdf>",
     "<rgb> needs one or three numbers, got '1 2'"},
    {"FourColors", "<bsdf type='diffuse'><rgb name='reflectance' ^value='1 2 3 4'/></bsdf>",
     "<rgb> needs one or three numbers, got '1 2 3 4'"},
    {"HashColor", "<bsdf type='diffuse'><rgb name='reflectance' ^value='#ff0000'/></bsdf>",
     "<rgb> needs one or three numbers, got '#ff0000'"},
    {"NanInColor", "<bsdf type='diffuse'><rgb name='reflectance' ^value='0 nan 0'/></bsdf>",
     "<rgb> needs one or three numbers, got '0 nan 0'"},
    {"HalfPoint", "<texture type='probe'>^<point name='vector' x='1' y='2'/></texture>",
     "<point> needs an attribute 'value', or all of x, y, z"},
    {"BothPoints", "<texture type='probe'><point name='vector' value='1 2 3' ^x='1'/></texture>",
     "'x' can't be combined with 'value'"},
    {"BadCoordinate", "<texture type='probe'><point name='vector' x='1' ^y='q' z='1'/></texture>",
     "'q' is not a number"},

    // Plugins of Mitsuba that are unsupported
    {"ShapeIsMissing", "<shape ^type='sdfgrid'><float name='scale' value='2'/></shape>",
     "unsupported shape 'sdfgrid' of Mitsuba 3 (--lenient renders without it)"},
    {"BsdfIsMissing", "<bsdf ^type='polarizer'><float name='theta' value='2'/></bsdf>",
     "unsupported bsdf 'polarizer' of Mitsuba 3 (--lenient renders without it)"},
    {"IntegratorIsMissing", "<integrator ^type='stokes'><integrator type='direct'/></integrator>",
     "unsupported integrator 'stokes' of Mitsuba 3 (--lenient renders without it)"},

    // Spectra
    {"SpectrumOfNoType",
     "<emitter type='point'><spectrum ^type='blackbox' name='intensity'/></emitter>",
     "unknown texture plugin 'blackbox' (did you mean 'blackbody'?)"},
    {"SpectrumOfATypeLacksAValue",
     "<emitter type='point'>^<spectrum type='uniform' name='intensity'/></emitter>",
     "texture 'uniform' needs parameter 'value', a float"},
    {"NegativeSpectrum",
     "<emitter type='point'><spectrum type='uniform' name='intensity'>"
     "^<float name='value' value='-1'/></spectrum></emitter>",
     "'value' must not be negative, got -1"},
    {"SpectrumOfUnequalLists",
     "<emitter type='point'><spectrum type='irregular' name='intensity'>"
     "<string name='wavelengths' value='400 500'/>^<string name='values' value='1 2 3'/>"
     "</spectrum></emitter>",
     "'values' is not a valid spectrum: a spectrum needs as many values as "
     "wavelengths, got 3 and 2"},
    {"SpectrumThatShrinks",
     "<emitter type='point'><spectrum type='regular' name='intensity'>"
     "<float name='wavelength_min' value='700'/><float name='wavelength_max' value='400'/>"
     "^<string name='values' value='1 2 3'/></spectrum></emitter>",
     "'values' is not a valid spectrum: wavelengths must increase"},
    {"SrgbAboveOne",
     "<bsdf type='diffuse' id='b'><spectrum type='srgb' name='reflectance'>"
     "^<rgb name='color' value='2 0 0'/></spectrum></bsdf><ref id='b'/>",
     "'color' must be between 0 and 1, got 2"},
    {"SpectrumOfNothing", "<bsdf type='diffuse'>^<spectrum name='reflectance'/></bsdf>",
     "<spectrum> needs one of the attributes 'value' and 'filename'"},
    {"SpectrumOfBoth",
     "<bsdf type='diffuse'>^<spectrum name='reflectance' value='1' filename='a'/></bsdf>",
     "<spectrum> needs one of the attributes 'value' and 'filename'"},
    {"SpectrumOfWords", "<bsdf type='diffuse'><spectrum name='reflectance' ^value='a'/></bsdf>",
     "'a' is not a number or a list of 'wavelength:value'"},
    {"SpectrumBackwards",
     "<bsdf type='diffuse'><spectrum name='reflectance' ^value='500:1 400:1'/></bsdf>",
     "wavelengths must increase, but 400 doesn't"},
    {"SpectrumHalf",
     "<bsdf type='diffuse'><spectrum name='reflectance' ^value='500:1 600'/></bsdf>",
     "'600:' is not a wavelength and a value"},
    {"SpectrumOfOne", "<bsdf type='diffuse'><spectrum name='reflectance' ^value='500:1'/></bsdf>",
     "a spectrum needs at least two wavelengths"},
    {"SpectrumFileMissing",
     "<bsdf type='diffuse'><spectrum name='reflectance' ^filename='no.spd'/></bsdf>",
     "there is no file 'no.spd'; looked in ."},

    // Transforms
    {"ScaleOfZero",
     "<shape type='sphere'><transform name='to_world'>^<scale value='1 0 1'/></transform></shape>",
     "<scale> makes the transform singular"},
    {"RotateWithoutAxis",
     "<shape type='sphere'><transform name='to_world'>^<rotate angle='9'/></transform></shape>",
     "<rotate> needs an attribute 'value', or some of x, y, z"},
    {"RotateAroundNothing",
     "<shape type='sphere'><transform name='to_world'>^<rotate angle='9' x='0'/>"
     "</transform></shape>",
     "the axis of a rotation can't be zero"},
    {"RotateByWord",
     "<shape type='sphere'><transform name='to_world'><rotate ^angle='right' x='1'/>"
     "</transform></shape>",
     "'right' is not an angle in degrees"},
    {"MatrixOfTen",
     "<shape type='sphere'><transform name='to_world'><matrix ^value='1 2 3 4 5 6 7 8 9 10'/>"
     "</transform></shape>",
     "a <matrix> needs 9 or 16 numbers, got 10"},
    {"SingularMatrix",
     "<shape type='sphere'><transform name='to_world'>^<matrix value='1 2 3 4 5 6 7 8 9'/>"
     "</transform></shape>",
     "<matrix> makes the transform singular"},
    {"LookatItself",
     "<shape type='sphere'><transform name='to_world'>^<lookat origin='1 2 3' target='1 2 3'/>"
     "</transform></shape>",
     "origin and target are the same point"},
    {"LookatUp",
     "<shape type='sphere'><transform name='to_world'>"
     "<lookat origin='0 0 0' target='0 0 1' ^up='0 0 2'/></transform></shape>",
     "'up' is parallel to the viewing direction"},

    // Names and references
    {"PropertyTwice",
     "<bsdf type='diffuse'><rgb name='reflectance' value='.5'/>\n"
     "^<rgb name='reflectance' value='.5'/></bsdf>",
     "'reflectance' is given twice (first at scene.xml:1:45)"},
    {"NameTwiceInScene", "<bsdf type='diffuse' name='a'/>^<bsdf type='diffuse' name='a'/>",
     "'a' is given twice (first at scene.xml:1:24)"},
    {"IdTwice", "<bsdf type='diffuse' id='a'/>\n<shape type='sphere' ^id='a'/>",
     "the id 'a' is given twice (first at scene.xml:1:45)"},
    {"IdTwiceNested", "<shape type='sphere' id='a'><bsdf type='diffuse' ^id='a'/></shape>",
     "the id 'a' is given twice (first at scene.xml:1:45)"},
    {"DanglingRef", "<bsdf type='diffuse' id='red'/><shape type='sphere'><ref ^id='rad'/></shape>",
     "unknown id 'rad' (did you mean 'red'?)"},
    {"RefToItself", "<texture type='probe' id='a'><ref name='texture' ^id='a'/></texture>",
     "'a' refers to an object that it is part of"},
    {"RefInCircle",
     "<texture type='probe' id='a'><ref name='texture' id='b'/></texture>"
     "<texture type='probe' id='b'><ref name='texture' ^id='a'/></texture>",
     "'a' refers to an object that it is part of"},
    {"AliasOfNothing", "<alias ^id='a' as='b'/><bsdf type='diffuse' id='a'/>",
     "no earlier object has the id 'a'"},
    {"AliasTwice", "<bsdf type='diffuse' id='a'/><alias id='a' as='b'/><alias id='a' ^as='b'/>",
     "the id 'b' is given twice"},
    {"AliasTakesAnId", "<bsdf type='diffuse' id='a'/><alias id='a' ^as='a'/>",
     "the id 'a' is given twice"},

    {"TooFar",
     "<shape type='sphere'/>\n^<shape type='sphere'><point name='center' value='0 2e18 "
     "0'/></shape>",
     "this sphere extends beyond 1e18 units, which the ray tracer doesn't support"},

    // Substitution, include, path
    {"Undefined", "<bsdf type='diffuse' ^id='$x'/>", "undefined parameter '$x'"},
    {"UndefinedSuggests",
     "<default name='samples' value='1'/>\n<bsdf type='diffuse' ^id='$sampels'/>",
     "undefined parameter '$sampels' (did you mean '$samples'?)"},
    {"UsedBeforeItsDefault", "<bsdf type='diffuse' ^id='$x'/><default name='x' value='1'/>",
     "undefined parameter '$x'"},
    {"LoneDollar", "<bsdf type='diffuse' ^id='a$'/>", "undefined parameter '$'"},
    {"UnusedDefine",
     "<default name='samples' value='1'/><bsdf type='diffuse' id='s$samples'/>",
     "the scene doesn't use -D sampels (did you mean 'samples'?)",
     {{"sampels", "1"}}},
    {"DefineOnlyOfADefault",
     "<default name='x' value='1'/>",
     "the scene doesn't use -D x",
     {{"x", "1"}}},
    {"GrowingDefaults",
     "<default name='a' value='xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx'/>"
     "<default name='b' value='$a$a$a$a$a$a$a$a$a$a$a$a$a$a$a$a$a$a$a$a$a$a$a$a$a$a$a$a$a$a$a$a'/>"
     "<default name='c' value='$b$b$b$b$b$b$b$b$b$b$b$b$b$b$b$b$b$b$b$b$b$b$b$b$b$b$b$b$b$b$b$b'/>"
     "<default name='d' ^value='$c$c$c$c$c$c$c$c$c$c$c$c$c$c$c$c$c$c$c$c$c$c$c$c$c$c$c$c$c$c$c'/>",
     "the value grows too long by substitution"},
    {"IncludeMissing", "\n <include ^filename='no.xml'/>",
     "there is no file 'no.xml'; looked in ."},
    {"IncludeEmpty", "<include ^filename=''/>", "a file name is empty"},
    {"PathMissing", "<path ^value='no/such/folder'/>", "no such folder: 'no/such/folder'"},
    {"PathTooDeep", "<shape type='sphere'>^<path value='.'/></shape>",
     "<path> must be a child of the root"},
};

void PrintTo(const Wrong& wrong, std::ostream* stream) {
  *stream << wrong.xml;
}

class Errors : public testing::TestWithParam<Wrong> {};

TEST_P(Errors, HaveTheirPositions) {
  std::string xml = GetParam().xml;
  xml = xml[0] == '!' ? xml.substr(1) : "<scene version='3.0.0'>" + xml + "</scene>";
  std::string place = "scene.xml: ";
  if (const size_t mark = xml.find('^'); mark != std::string::npos) {
    int line = 1, column = 1;
    for (size_t i = 0; i < mark; ++i) {
      column = xml[i] == '\n' ? 1 : column + 1;
      line += xml[i] == '\n';
    }
    place = "scene.xml:" + std::to_string(line) + ":" + std::to_string(column) + ": ";
    xml.erase(mark, 1);
  }
  LoadOptions options;
  options.defines = GetParam().defines;
  const std::string message =
      error_of([&] { load_scene_from_string(xml, "scene.xml", options, probe_registry()); });
  const std::string expected = place + GetParam().message;
  EXPECT_EQ(message.substr(0, expected.size()), expected) << message;
}

INSTANTIATE_TEST_SUITE_P(Table, Errors, testing::ValuesIn(kWrong),
                         [](const auto& row) { return row.param.name; });

}  // namespace
}  // namespace kinome::test::scene_errors_test
