/* The disk of a trial, folder "disk", and what it may hold after a power cut, folder "cut". */
#ifndef FURROW_TEST_FAULT_POWER_IMAGE_H
#define FURROW_TEST_FAULT_POWER_IMAGE_H

#include "../long.h"
#include "known.h"
#include "power_disk.h"
#include "power_vfs.h"

#define SEEDS (long_run() ? 12u : 4u)

static void folder_empty(const char *of)
{
	DIR *dir = opendir(of);
	assert_non_null(dir);
	for (struct dirent *entry; (entry = readdir(dir)) != NULL;) {
		char path[512];
		snprintf(path, sizeof path, "%s/%s", of, entry->d_name);
		if (entry->d_name[0] != '.')
			unlink(path);
	}
	closedir(dir);
}

static void name_trial(const char *what, uint64_t cut, int seed)
{
	snprintf(trial_name, sizeof trial_name, "%s, power cut at operation %llu, disk %d", what,
		 (unsigned long long)cut, seed);
}

/* Makes what the disk may hold after the cut. Returns the path of a file of it, valid until the next call. */
static const char *image(const char *what, const char *name, uint64_t cut, uint32_t seed)
{
	static char path[256];
	name_trial(what, cut, (int)seed);
	folder_empty(in_folder("cut"));
	power_disk_image(seed, in_folder("cut"));
	snprintf(path, sizeof path, "%s/%s", in_folder("cut"), name);
	return path;
}

static void tell_counts(uint64_t cuts)
{
	if (getenv("FAULT_COUNTS") != NULL)
		print_message("power cuts: %llu; so far %zu questions of disks, %zu of them different\n", (unsigned long long)cuts, known_asked,
			      known_count);
}

/* Cuts the power at every operation of a trial, which returns how many it makes, and checks that they are more than `least`. */
static __attribute__((unused)) void every_cut(uint64_t (*trial)(uint64_t cut), uint64_t least)
{
	uint64_t cut = 1;
	while (trial(cut) >= cut)
		cut++;
	assert_true(cut > least);
	tell_counts(cut);
}

static int make_disk(void)
{
	return mkdir(in_folder("disk"), 0777) + mkdir(in_folder("cut"), 0777);
}

static int remove_disk(void)
{
	folder_empty(in_folder("disk"));
	folder_empty(in_folder("cut"));
	return rmdir(in_folder("disk")) + rmdir(in_folder("cut"));
}

#endif
