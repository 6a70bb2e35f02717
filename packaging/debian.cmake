# The package for Debian 12: cpack in a build that is configured for /usr (preset deb; scripts/check_package does all of
# it). There roslaunch and rosrun look without being told: /usr/share and /usr/lib. Any other prefix is catkin's install
# space with a setup.bash of its own, and gets no package.
if(NOT CMAKE_INSTALL_PREFIX STREQUAL "/usr")
  return()
endif()

set(DOC_FOLDER share/doc/raven2-trainer)
# Pages lie to each other as in the source tree, so their links hold (scripts/check_package looks).
install(DIRECTORY doc DESTINATION ${DOC_FOLDER} PATTERN __pycache__ EXCLUDE
        PATTERN site EXCLUDE)  # what makes the site of them
install(FILES README.md CONTRIBUTING.md SECURITY.md CHANGELOG.md packaging/copyright DESTINATION ${DOC_FOLDER})
install(FILES urdf/README.md DESTINATION ${DOC_FOLDER}/urdf)

# Debian wants its own kind of changelog, compressed without a time stamp.
execute_process(COMMAND gzip -9nc ${CMAKE_SOURCE_DIR}/packaging/changelog
                OUTPUT_FILE ${CMAKE_BINARY_DIR}/changelog.gz COMMAND_ERROR_IS_FATAL ANY)
#catkin_lint: ignore_once missing_install_file missing_file
install(FILES ${CMAKE_BINARY_DIR}/changelog.gz DESTINATION ${DOC_FOLDER})

# What the programs call is what install_dependencies installs for running; libraries are found by dpkg-shlibdeps.
execute_process(COMMAND ${CMAKE_SOURCE_DIR}/scripts/install_dependencies --list run
                OUTPUT_VARIABLE run_packages OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE "[ \n]+" ", " run_packages "${run_packages}")
string(REPLACE "libosmesa6" "libosmesa6 | libegl1" run_packages "${run_packages}")  # either draws

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME raven2-trainer)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "raven2_trainer maintainers <maintainers@raven2-trainer.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "training simulator for the Raven-II surgical robot (ROS 1)")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
"Real-time, hardware-in-the-loop training simulator: a dynamic model of both
arms, a haptic cue where robot and model part, injection of safety hazards,
path planning, recording, reports and offscreen rendering. Without a robot, a
virtual one takes its place. For education and research; no medical device.")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "catkin, python3-rosmaster, ${run_packages}")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "rviz, chrony")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION TRUE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_SOURCE_DIR}/packaging/remove_pycache.cmake)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ
                                                WORLD_EXECUTE)
include(CPack)
