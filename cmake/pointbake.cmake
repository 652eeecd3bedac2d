# pointbake_module(name sources...): an object library of one layer; all of them together are the library pointbake.
# pointbake_test(name [LABELS labels...] SOURCES files... LINKS modules...): one GoogleTest program, found by ctest.

add_library(pointbake_flags INTERFACE)
target_compile_features(pointbake_flags INTERFACE cxx_std_20)
target_include_directories(pointbake_flags INTERFACE
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src>)
# -ffp-contract=off: the same bits with and without fused multiply-add.
target_compile_options(pointbake_flags INTERFACE -Wall -Wextra -Wshadow -Wconversion -ffp-contract=off)
target_compile_definitions(pointbake_flags INTERFACE $<$<BOOL:${POINTBAKE_ASSERTS}>:POINTBAKE_ASSERTS>)
if(POINTBAKE_WERROR)
    target_compile_options(pointbake_flags INTERFACE -Werror)
endif()

function(pointbake_module name)
    add_library(pointbake_${name} OBJECT ${ARGN})
    target_link_libraries(pointbake_${name} PUBLIC pointbake_flags)
    set_target_properties(pointbake_${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
    set_property(GLOBAL APPEND PROPERTY POINTBAKE_MODULES pointbake_${name})
endfunction()

function(pointbake_test name)
    cmake_parse_arguments(ARG "" "" "LABELS;SOURCES;LINKS" ${ARGN})
    add_executable(${name} ${ARG_SOURCES})
    target_link_libraries(${name} PRIVATE ${ARG_LINKS} pointbake_core pointbake_flags GTest::gtest GTest::gmock GTest::gtest_main)
    target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
    # Tests are compiled once and run once: compiling is what takes the time.
    target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
    gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST PROPERTIES LABELS "${ARG_LABELS}" TIMEOUT 300)
endfunction()
