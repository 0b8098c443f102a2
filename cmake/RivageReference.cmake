# rivage_reference(rivage): the man page and the completions of a program, which the program writes
# itself (`rivage man`, `rivage completions bash`), so that they cannot say anything else than it
# does. They go to share/ of the build folder; `cmake --install` puts them and the program in place.
include(GNUInstallDirs)
set(RIVAGE_REFERENCE_SCRIPT ${CMAKE_CURRENT_LIST_DIR}/RivageReferenceScript.cmake)
add_custom_target(reference ALL)

# One file: what the program prints when it is called with ARGN.
function(rivage_reference_file program output)
    set(file ${CMAKE_BINARY_DIR}/${output})
    list(JOIN ARGN "|" arguments)
    add_custom_command(
        OUTPUT ${file}
        COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:${program}> "-DARGUMENTS=${arguments}"
                -DOUTPUT=${file} -P ${RIVAGE_REFERENCE_SCRIPT}
        DEPENDS ${program} ${RIVAGE_REFERENCE_SCRIPT}
        COMMENT "Writing ${output}"
        VERBATIM)
    set_property(GLOBAL APPEND PROPERTY RIVAGE_REFERENCE_${program} ${file})
    get_filename_component(folder ${output} DIRECTORY)
    string(REGEX REPLACE "^share" "${CMAKE_INSTALL_DATADIR}" folder ${folder})
    install(FILES ${file} DESTINATION ${folder})
endfunction()

function(rivage_reference program)
    rivage_reference_file(${program} share/man/man1/${program}.1 man)
    rivage_reference_file(${program} share/bash-completion/completions/${program} completions bash)
    rivage_reference_file(${program} share/zsh/site-functions/_${program} completions zsh)
    rivage_reference_file(${program} share/fish/vendor_completions.d/${program}.fish completions fish)
    get_property(files GLOBAL PROPERTY RIVAGE_REFERENCE_${program})
    add_custom_target(${program}_reference DEPENDS ${files})
    add_dependencies(reference ${program}_reference)
endfunction()
