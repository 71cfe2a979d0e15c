"""Some tests of every program of the command, above all those of wrong input. They run under sanitizers, the other tests of this folder without.
Of many cases that are alike they try every eighth (sampled() in furrow_test.py). `sh tools/test.sh long` runs more tests, and all cases."""
import importlib
import os
import sys
import unittest

from furrow_test import FULL, has_gdal

CHOSEN = {
    "contract": ["Usage", "BadInput.test_missing_empty_garbage_and_truncated_stores_are_status_3",
                 "BadInput.test_missing_empty_and_garbage_sources_are_status_3_and_leave_nothing",
                 "BadInput.test_a_png_with_holes",
                 "BadInput.test_a_scene_with_a_wrong_key_names_file_line_and_what_is_allowed",
                 "RoundTrips.test_a_png_comes_back_as_it_was", "RoundTrips.test_info_holds_what_the_contract_names",
                 "RoundTrips.test_query_reads_points_from_stdin", "RoundTrips.test_query_casts_rays",
                 "Maps.test_what_is_no_picture_is_refused_and_leaves_nothing",
                 "Drives.test_a_drive_leaves_ruts_figures_and_a_clean_store", "Drives.test_ctrl_c_ends_cleanly_with_130"],
    "branches": ["Merge.test_what_cannot_be_merged_is_refused_and_nothing_is_left",
                 "Relink.test_what_is_not_the_base_is_refused_and_the_overlay_kept",
                 "Flatten.test_what_cannot_be_flattened_is_refused_and_nothing_is_left"],
    "cache_sim": ["CacheSim.test_what_is_no_trace_is_refused_and_nothing_is_left"],
    "cameras": ["Cameras.test_a_body_that_is_not_there_is_refused"],
    "drive_resume": ["Resume.test_a_damaged_record_is_refused_and_named"],
    "edit": ["Refusals"],
    "explain": ["Explain.test_what_is_wrong_is_told"],
    "help": ["Help.test_what_is_not_printed_is_refused"],
    "fit_soil": ["FitSoil.test_what_is_wrong_is_refused_and_leaves_nothing"],
    "history": ["History.test_what_cannot_be_is_refused"],
    "meshes": ["Meshes.test_refusals"],
    "pins": ["Pins.test_a_parent_that_cannot_be_told_says_so"],
    "study": ["Study.test_refused_studies"],
    "tiles": ["Tiles.test_refusals"],
    "overlay": ["Refusals.test_what_is_no_overlay_of_that_store_is_refused_and_kept"],
    "resume": ["Resume.test_a_damaged_part_is_refused_and_kept"],
    "soil_rasters": ["SoilRasters.test_what_cannot_be_used_is_refused_before_anything_is_driven"],
    "soil_map": ["SoilMap.test_what_is_no_map_is_refused_before_anything_is_driven"],
}
OF_GDAL = {
    "failures": ["Unreadable", "Damage"],
    "insets": ["Insets.test_what_cannot_be_an_inset_is_refused_and_leaves_nothing"],
    "nodata": ["Nodata.test_no_kernel_reaches_over_a_holes_edge"],
    "values": ["Bytes"],
}
LONG = {
    "contract": ["BadInput.test_an_existing_store_is_not_overwritten_unless_asked",
                 "BadInput.test_a_dry_run_makes_nothing_and_tells_what_is_in_the_way", "Drives.test_pictures_are_written"],
    "branches": ["Merge.test_what_both_changed_is_listed_and_nothing_is_made"],
    "cache_sim": ["CacheSim.test_table_and_plot"],
    "explain": ["Explain.test_the_store_decides_level_and_spacing", "Explain.test_a_drive_tells_the_same_on_stderr"],
    "study": ["Study.test_a_hypercube_has_one_value_in_each_part", "Study.test_one_that_fails_does_not_stop_the_others"],
    "notes": ["Notes.test_the_unit_of_a_number_is_told_once"],
    "overlay": ["Drives.test_one_overlay_has_one_drive_and_its_base_may_be_driven_meanwhile"],
    "resume": ["Resume.test_interrupted_it_says_how_to_go_on_and_does"],
    "view": ["View.test_a_display_that_is_lost_leaves_nothing_behind"],
}
LONG_OF_GDAL = {
    "failures": ["SeamsThatDisagree", "FullDisk.test_a_store_that_is_to_be_overwritten_survives_a_full_disk"],
    "insets": ["Insets.test_holes_are_filled_and_a_ragged_outline_is_feathered"],
    "round_trips": ["Places.test_levels_and_windows_export_in_their_place"],
    "values": ["Values.test_a_negative_scale_keeps_the_bound"],
}


def suite():
    if not FULL:
        os.environ["FURROW_EVERY"] = "8"
    found = unittest.TestSuite()
    lists = [(CHOSEN, True), (OF_GDAL, has_gdal()), (LONG, FULL), (LONG_OF_GDAL, FULL and has_gdal())]
    for name, tests in [row for chosen, runs in lists if runs for row in chosen.items()]:
        module = importlib.import_module(name)
        missing = getattr(module, "NEEDED", [])
        if name == "view" and not (module.WINDOW and all(map(module.shutil.which, missing))):
            continue
        found.addTests(unittest.defaultTestLoader.loadTestsFromNames(tests, module))
    return found


if __name__ == "__main__":
    sys.exit(not unittest.TextTestRunner(verbosity=2).run(suite()).wasSuccessful())
