# What every target of the project has in common.
add_library(rivage_warnings INTERFACE)
add_library(rivage::warnings ALIAS rivage_warnings)
target_compile_options(rivage_warnings INTERFACE
    -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wno-missing-field-initializers
    -Werror
    # g++ 12 at -O3 takes `"text" + string` for an overlapping copy (GCC bug 105651).
    $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)

# The same result on every machine: no contraction, no threads inside Eigen.
add_library(rivage_settings INTERFACE)
add_library(rivage::settings ALIAS rivage_settings)
target_compile_features(rivage_settings INTERFACE cxx_std_20)
target_compile_options(rivage_settings INTERFACE -ffp-contract=off)
target_compile_definitions(rivage_settings INTERFACE EIGEN_DONT_PARALLELIZE)
target_include_directories(rivage_settings INTERFACE ${PROJECT_SOURCE_DIR})
if(RIVAGE_SANITIZE)
    add_compile_options(-fsanitize=${RIVAGE_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
    add_link_options(-fsanitize=${RIVAGE_SANITIZE})
endif()

# rivage_library(core): the library rivage::core in the folder core.
function(rivage_library name)
    add_library(rivage_${name} STATIC)
    add_library(rivage::${name} ALIAS rivage_${name})
    target_link_libraries(rivage_${name} PUBLIC rivage::settings PRIVATE rivage::warnings)
endfunction()

# rivage_test(core_surface LIBRARIES rivage::core SOURCES a_test.cpp): one doctest program.
function(rivage_test name)
    cmake_parse_arguments(ARG "" "" "SOURCES;LIBRARIES" ${ARGN})
    add_executable(test_${name} ${ARG_SOURCES})
    target_link_libraries(test_${name} PRIVATE rivage_test_main rivage::warnings ${ARG_LIBRARIES})
    set_target_properties(test_${name} PROPERTIES
        RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
    add_test(NAME ${name} COMMAND test_${name})
    set_property(GLOBAL APPEND PROPERTY RIVAGE_TEST_TARGETS test_${name})
endfunction()
