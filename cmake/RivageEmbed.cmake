# rivage_embed(TARGET rivage_web FUNCTION webAssets ROOT ${CMAKE_CURRENT_SOURCE_DIR}
#              FILES index.html viewer.js [DEPENDS a_target])
# Builds files into a target: defines `std::span<const WebAsset> rivage::server::FUNCTION()`
# (server/web/assets.h). Paths are relative to ROOT, and so are the paths that are served; files may
# be made by the build. Needs an ELF assembler, nothing else: no xxd, no resource compiler.
set(RIVAGE_EMBED_SCRIPT ${CMAKE_CURRENT_LIST_DIR}/RivageEmbedScript.cmake)

function(rivage_embed)
    cmake_parse_arguments(ARG "" "TARGET;FUNCTION;ROOT" "FILES;DEPENDS" ${ARGN})
    set(source ${CMAKE_CURRENT_BINARY_DIR}/${ARG_FUNCTION}.cpp)
    list(TRANSFORM ARG_FILES PREPEND ${ARG_ROOT}/ OUTPUT_VARIABLE inputs)
    list(JOIN ARG_FILES "|" files)
    add_custom_command(
        OUTPUT ${source}
        COMMAND ${CMAKE_COMMAND} "-DFUNCTION=${ARG_FUNCTION}" "-DROOT=${ARG_ROOT}"
                "-DFILES=${files}" "-DOUTPUT=${source}" -P ${RIVAGE_EMBED_SCRIPT}
        DEPENDS ${inputs} ${RIVAGE_EMBED_SCRIPT} ${ARG_DEPENDS}
        COMMENT "Embedding ${ARG_FUNCTION}"
        VERBATIM)
    set_source_files_properties(${source} PROPERTIES OBJECT_DEPENDS "${inputs}")
    target_sources(${ARG_TARGET} PRIVATE ${source})
endfunction()
