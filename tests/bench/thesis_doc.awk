# Tables of docs/thesis.md: those of the thesis beside ours.
# usage: awk -F, -f thesis_doc.awk thesis_tables.csv RESULTS.csv...
#   RESULTS.csv are what tests/bench/thesis wrote; each table begins with a line "@NAME".

function cell(value, digits) {
    return value == "" ? "" : sprintf("%." digits "f", value)
}

function ratio(a, b) {
    return a == "" || b == "" || b == 0 ? "" : sprintf("%.2f", a / b)
}

# Maximum and average of both measures, of the thesis or ours.
function four(set, id) {
    return cell(value[set, id, "hausdorff_max"], 4) " | " cell(value[set, id, "hausdorff_avg"], 4) " | " \
        cell(value[set, id, "fmpd_max"], 4) " | " cell(value[set, id, "fmpd_avg"], 4)
}

function four_ratios(set, a, b) {
    return ratio(value[set, a, "hausdorff_max"], value[set, b, "hausdorff_max"]) " | " \
        ratio(value[set, a, "hausdorff_avg"], value[set, b, "hausdorff_avg"]) " | " \
        ratio(value[set, a, "fmpd_max"], value[set, b, "fmpd_max"]) " | " \
        ratio(value[set, a, "fmpd_avg"], value[set, b, "fmpd_avg"])
}

function begin_table(name, head, columns,    i) {
    printf "@%s\n%s\n", name, head
    for (i = 0; i < columns; i++)
        printf "|---"
    print "|"
}

function get(column) {
    return $at[column]
}

function remember(set, id,    i, names, n) {
    n = split("hausdorff_max hausdorff_avg fmpd_max fmpd_avg bytes ratio", names, " ")
    for (i = 1; i <= n; i++)
        if (names[i] in at)
            value[set, id, names[i]] = get(names[i])
}

FNR == 1 {
    file++
    delete at
    for (i = 1; i <= NF; i++)
        at[$i] = i
    next
}

# The thesis: rows of sequences that we have not are left out.
file == 1 && get("table") == "table8.1" { remember("thesis", "8.1 " get("source") " " get("frames") " all") }
file == 1 && get("table") == "table8.2" {
    remember("thesis", "8.2 " get("source") " " get("loss") " " get("representation"))
}
file == 1 && get("table") == "table8.3" { remember("thesis", "gap " get("source") " " get("frames")) }
file == 1 { next }

!(get("source") in sources) { sources[get("source")] = 1; source[++source_count] = get("source") }
{ experiments[get("experiment")] = 1 }
get("experiment") == "table8.1" { remember("ours", "8.1 " get("source") " " get("frames") " " get("measured")) }
get("experiment") == "table8.2" {
    remember("ours", "8.2 " get("source") " " get("loss") " " get("representation"))
}
get("experiment") ~ /^table8\.[34]$/ {
    remember(get("representation"), "gap " get("source") " " get("frames"))
    gap = get("frames")
    sub(/-.*/, "", gap)
    if (!((get("source"), gap) in gaps)) {
        gaps[get("source"), gap] = 1
        gap_list[get("source")] = gap_list[get("source")] " " substr(gap, 4)
    }
}
get("experiment") == "figure8.1" {
    remember("ours", "8.1f " get("source") " " get("samples"))
    if (!(get("samples") in series)) {
        series[get("samples")] = 1
        samples[++sample_count] = get("samples")
    }
}
get("experiment") ~ /^figure8\.[23]$/ {
    plain = get("compression")
    zipped = sub(/-zip$/, "", plain)
    remember(zipped ? "zip" : "ours", get("experiment") " " plain)
    if (!zipped)
        codings[get("experiment")] = codings[get("experiment")] " " plain
}

function table_8_1(    s, f, m, text) {
    text["all"] = "all"
    text["even"] = "every second, fitted at both rates"
    text["odd"] = "those between, left out at the half rate"
    begin_table("table8.1", "| data | fitted | measured on | max. Haus. | avg. Haus. | max. FMPD | avg. FMPD " \
        "| thesis: max. Haus. | avg. Haus. | max. FMPD | avg. FMPD |", 11)
    for (s = 1; s <= source_count; s++)
        for (f = 0; f < 2; f++)
            for (m = 0; m < 3; m++) {
                measured = m == 0 ? "all" : m == 1 ? "even" : "odd"
                id = "8.1 " source[s] " " (f ? "half" : "full") " " measured
                printf "| %s | %s | %s | %s | %s |\n", source[s], f ? "every second" : "all", text[measured],
                    four("ours", id), four("thesis", id)
            }
    begin_table("table8.1-ratios", "| data | measured on | max. Haus. | avg. Haus. | max. FMPD | avg. FMPD |", 6)
    for (s = 1; s <= source_count; s++) {
        for (m = 0; m < 3; m++) {
            measured = m == 0 ? "all" : m == 1 ? "even" : "odd"
            printf "| %s | %s | %s |\n", source[s], text[measured],
                four_ratios("ours", "8.1 " source[s] " half " measured, "8.1 " source[s] " full " measured)
        }
        if (("thesis", "8.1 " source[s] " half all", "fmpd_avg") in value)
            printf "| %s | thesis: all | %s |\n", source[s],
                four_ratios("thesis", "8.1 " source[s] " half all", "8.1 " source[s] " full all")
    }
}

function ratio_row(s, text, a, b) {
    a = "8.2 " source[s] " " a
    b = "8.2 " source[s] " " b
    printf "| %s | %s | %s | %s | %s | %s |\n", source[s], text,
        ratio(value["ours", a, "hausdorff_avg"], value["ours", b, "hausdorff_avg"]),
        ratio(value["thesis", a, "hausdorff_avg"], value["thesis", b, "hausdorff_avg"]),
        ratio(value["ours", a, "fmpd_avg"], value["ours", b, "fmpd_avg"]),
        ratio(value["thesis", a, "fmpd_avg"], value["thesis", b, "fmpd_avg"])
}

function table_8_2(    s, l, r) {
    begin_table("table8.2", "| data | loss | Fourier features | max. Haus. | avg. Haus. | max. FMPD | avg. FMPD " \
        "| thesis: max. Haus. | avg. Haus. | max. FMPD | avg. FMPD |", 11)
    for (s = 1; s <= source_count; s++)
        for (l = 0; l < 2; l++)
            for (r = 0; r < 2; r++) {
                id = "8.2 " source[s] " " (l ? "surface" : "mae") " " (r ? "fourier" : "mlp")
                printf "| %s | %s | %s | %s | %s |\n", source[s], l ? "surface-sensitive" : "MAE", r ? "yes" : "no",
                    four("ours", id), four("thesis", id)
            }
    begin_table("table8.2-ratios", "| data | change | avg. Haus. | thesis | avg. FMPD | thesis |", 6)
    for (s = 1; s <= source_count; s++) {
        ratio_row(s, "Fourier features, MAE", "mae fourier", "mae mlp")
        ratio_row(s, "Fourier features, surface-sensitive", "surface fourier", "surface mlp")
        ratio_row(s, "surface-sensitive, no Fourier features", "surface mlp", "mae mlp")
        ratio_row(s, "surface-sensitive, Fourier features", "surface fourier", "mae fourier")
    }
}

# Ours without and with Fourier features, and the thesis; a dash where no surface came back.
function gap_row(s, frame, key,    set, side, line, v) {
    line = "| " source[s] " | " frame
    for (set = 1; set <= 3; set++)
        for (side = 1; side <= 3; side++) {
            v = value[gap_set[set], "gap " source[s] " gap" frame "-" side, key]
            line = line " | " (v == "" && set < 3 ? "-" : cell(v, 4))
            sum[set, side] += v
            number[set, side] += v != ""
        }
    print line " |"
}

function mean_rows(s,    set, side, mean, line, share) {
    line = "| " source[s] " | average"
    share = "| " source[s] " | of (3)"
    for (set = 1; set <= 3; set++)
        for (side = 1; side <= 3; side++) {
            mean[set, side] = number[set, side] ? sum[set, side] / number[set, side] : ""
            line = line " | " cell(mean[set, side], 4)
            share = share " | " ratio(mean[set, side], mean[set, 1])
        }
    print line " |\n" share " |"
}

function table_gap(name, key,    s, i, n, frames) {
    split("mlp fourier thesis", gap_set, " ")
    begin_table(name, "| data | frame | plain: (3) | (5) | (7) | Fourier: (3) | (5) | (7) | thesis: (3) | (5) | (7) |",
        11)
    for (s = 1; s <= source_count; s++) {
        n = split(gap_list[source[s]], frames, " ")
        delete sum
        delete number
        for (i = 1; i <= n; i++)
            gap_row(s, frames[i], key)
        mean_rows(s)
    }
}

function figure_samples(    s, i, head) {
    head = "| samples of a frame"
    for (s = 1; s <= source_count; s++)
        head = head " | " source[s] ": avg. FMPD | avg. Haus."
    begin_table("figure8.1", head " |", 1 + 2 * source_count)
    for (i = 1; i <= sample_count; i++) {
        printf "| %d", samples[i]
        for (s = 1; s <= source_count; s++) {
            id = "8.1f " source[s] " " samples[i]
            printf " | %s | %s", cell(value["ours", id, "fmpd_avg"], 4), cell(value["ours", id, "hausdorff_avg"], 4)
        }
        print " |"
    }
}

function figure_bits(name,    i, n, list, bits) {
    begin_table(name, "| bits a weight | bytes | ratio | ZIP: bytes | ratio | avg. FMPD | avg. Haus. |", 7)
    n = split(codings[name], list, " ")
    for (i = 1; i <= n; i++) {
        id = name " " list[i]
        bits = list[i] == "float32" ? "32 (float)" : substr(list[i], 2)
        printf "| %s | %d | %.1f | %s | %s | %s | %s |\n", bits, value["ours", id, "bytes"], value["ours", id, "ratio"],
            value["zip", id, "bytes"], cell(value["zip", id, "ratio"], 1), cell(value["ours", id, "fmpd_avg"], 4),
            cell(value["ours", id, "hausdorff_avg"], 4)
    }
}

END {
    if ("table8.1" in experiments)
        table_8_1()
    if ("table8.2" in experiments)
        table_8_2()
    if ("table8.3" in experiments)
        table_gap("table8.3", "hausdorff_avg")
    if ("table8.4" in experiments)
        table_gap("table8.4", "fmpd_avg")
    if ("figure8.1" in experiments)
        figure_samples()
    if ("figure8.2" in experiments)
        figure_bits("figure8.2")
    if ("figure8.3" in experiments)
        figure_bits("figure8.3")
}
