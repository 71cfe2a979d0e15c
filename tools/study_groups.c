/* The values of a parameter, sorted into groups for a plot. */
#include "study_groups.h"

#include <math.h>
#include <string.h>

double study_groups_scale(const struct study_groups *groups, double value)
{
	return groups->logarithmic ? log10(value) : value;
}

static void cut_range(struct study_groups *groups, size_t parts)
{
	const double low = study_groups_scale(groups, groups->low), high = study_groups_scale(groups, groups->high);
	groups->cut = true;
	groups->count = parts;
	for (size_t i = 0; i < parts; i++)
		groups->values[i] = low + (high - low) * (double)i / (double)parts;
}

bool study_groups_find(const struct study *study, size_t parameter, size_t most, size_t parts, struct study_groups *groups)
{
	*groups =
		(struct study_groups){.low = INFINITY, .high = -INFINITY, .logarithmic = study->parameters[parameter].logarithmic};
	double value;
	for (size_t run = 0; run < study->run_count && !groups->text; run++)
		groups->text = !parse_number(study_value(study, run, parameter), &value);
	/* Each run of a hypercube has a value of its own. */
	bool many = !groups->text && study->parameters[parameter].values == NULL;
	for (size_t run = 0; run < study->run_count; run++) {
		const char *name = study_value(study, run, parameter);
		size_t i = 0;
		if (!groups->text && parse_number(name, &value)) {
			groups->low = fmin(groups->low, value);
			groups->high = fmax(groups->high, value);
			while (i < groups->count && groups->values[i] != value)
				i++;
		} else {
			while (i < groups->count && strcmp(groups->names[i], name) != 0)
				i++;
			value = (double)i;
		}
		if (i < groups->count)
			continue;
		if (groups->count == most) {
			many = true;
		} else {
			groups->names[groups->count] = name;
			groups->values[groups->count++] = value;
		}
	}
	groups->logarithmic = groups->logarithmic && groups->low > 0;
	if (many && groups->text)
		return false;
	if (many)
		cut_range(groups, groups->low < groups->high ? parts : 1);
	return true;
}

size_t study_groups_index(const struct study_groups *groups, const char *name, double *value)
{
	size_t i = groups->count - 1;
	*value = 0;
	if (groups->text) {
		while (i > 0 && strcmp(groups->names[i], name) != 0)
			i--;
		*value = (double)i;
		return i;
	}
	(void)parse_number(name, value);
	while (i > 0 && (groups->cut ? study_groups_scale(groups, *value) < groups->values[i] : *value != groups->values[i]))
		i--;
	return i;
}

double study_groups_edge(const struct study_groups *groups, size_t i)
{
	const double value = i < groups->count ? groups->values[i] : study_groups_scale(groups, groups->high);
	return groups->logarithmic ? pow(10, value) : value;
}
