# Every dependency is found, never downloaded: `./dev setup` installs what is missing.
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(TBB REQUIRED)
find_package(draco REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(spdlog REQUIRED)
find_package(CLI11 REQUIRED)
find_package(OpenSSL REQUIRED)
find_package(ZLIB REQUIRED)
find_package(SQLite3 3.35 REQUIRED)
find_package(prometheus-cpp REQUIRED COMPONENTS core)
find_package(tl-expected REQUIRED)

# Debian's draco package exports no target.
if(NOT TARGET draco::draco)
    find_library(RIVAGE_DRACO_LIBRARY draco REQUIRED)
    find_path(RIVAGE_DRACO_INCLUDE draco/mesh/mesh.h REQUIRED)
    add_library(rivage_draco INTERFACE)
    target_include_directories(rivage_draco SYSTEM INTERFACE ${RIVAGE_DRACO_INCLUDE})
    target_link_libraries(rivage_draco INTERFACE ${RIVAGE_DRACO_LIBRARY})
    add_library(draco::draco ALIAS rivage_draco)
endif()

# Debian's zstd package has no CMake file.
find_path(RIVAGE_ZSTD_INCLUDE zstd.h REQUIRED)
find_library(RIVAGE_ZSTD_LIBRARY zstd REQUIRED)

find_package(httplib 0.53.1 QUIET COMPONENTS ZLIB Zstd)
if(NOT httplib_FOUND)
    if(NOT EXISTS ${RIVAGE_HTTPLIB_DIR}/httplib.cpp)
        message(FATAL_ERROR "cpp-httplib 0.53.1 not found: run ./dev setup, or set RIVAGE_HTTPLIB_DIR")
    endif()
    add_library(rivage_httplib STATIC ${RIVAGE_HTTPLIB_DIR}/httplib.cpp)
    target_compile_features(rivage_httplib PUBLIC cxx_std_20)
    target_include_directories(rivage_httplib SYSTEM PUBLIC ${RIVAGE_HTTPLIB_DIR})
    target_compile_definitions(rivage_httplib PUBLIC
        CPPHTTPLIB_OPENSSL_SUPPORT CPPHTTPLIB_ZLIB_SUPPORT CPPHTTPLIB_ZSTD_SUPPORT)
    target_include_directories(rivage_httplib SYSTEM PUBLIC ${RIVAGE_ZSTD_INCLUDE})
    target_link_libraries(rivage_httplib PUBLIC
        OpenSSL::SSL OpenSSL::Crypto ZLIB::ZLIB ${RIVAGE_ZSTD_LIBRARY} Threads::Threads)
    set_target_properties(rivage_httplib PROPERTIES CXX_CLANG_TIDY "")  # not ours
    add_library(httplib::httplib ALIAS rivage_httplib)
endif()
