#include "client/compare/report_difference.h"

#include "client/compare/glb_document.h"

namespace rivage::client {

using proto::Json;

Json optionsThatDiffer(const Json& reportA, const Json& reportB) {
    const Json& a = memberOf(reportA, "options");
    const Json& b = memberOf(reportB, "options");
    Json list = Json::array();
    if (!a.is_object() || !b.is_object()) return list;
    const auto add = [&](const std::string& name) {
        const Json& valueA = memberOf(a, name.c_str());
        const Json& valueB = memberOf(b, name.c_str());
        if (valueA != valueB) list.push_back({{"name", name}, {"a", valueA}, {"b", valueB}});
    };
    for (const auto& [name, value] : a.items()) add(name);
    for (const auto& [name, value] : b.items())
        if (!a.contains(name)) add(name);
    return list;
}

Json energiesOf(const Json& reportA, const Json& reportB) {
    return {{"a", memberOf(reportA, "energy")}, {"b", memberOf(reportB, "energy")}};
}

Json notesOn(const Json& reportA, const Json& reportB) {
    Json notes = Json::array();
    if (!reportA.is_object() || !reportB.is_object()) return notes;
    const Json& inputA = memberOf(reportA, "input");
    const Json& inputB = memberOf(reportB, "input");
    if (memberOf(inputA, "dims") != memberOf(inputB, "dims") ||
        memberOf(inputA, "voxels") != memberOf(inputB, "voxels"))
        notes.push_back("the grids differ");
    for (const char* name : {"voxel_size", "pivot", "up"})
        if (memberOf(memberOf(reportA, "options"), name) !=
            memberOf(memberOf(reportB, "options"), name))
            notes.push_back(std::string(name) + " differs: the surfaces are compared as they lie");
    return notes;
}

}  // namespace rivage::client
