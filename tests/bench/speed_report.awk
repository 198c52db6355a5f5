# The rows of the speed bench as a table, as CSV or as JSON.
# usage: awk -v format=table|csv|json -f speed_report.awk ROWS
# ROWS: lines "# what: value", the columns' names, and rows of them (bench_util.h).  What the whole encoder reaches is
# put beside its kernels: operations of a sample, and ratios, are those of the row of the same network and threads.
BEGIN {
    FS = ","
    columns = "section,measure,threads,best,median,unit,runs,of_sgemm,of_fma,of_draco,cpu"
    width = split(columns, column, ",")
    sections = split("sdf fit encode decode draco memory", order, " ")
    titles["sdf"] = "Signed distance to a mesh (sdf)"
    titles["fit"] = "Fitting: kernels, and what the machine can do (fit)"
    titles["encode"] = "Encoding: nsdf-enc as a whole (encode)"
    titles["decode"] = "Decoding (decode)"
    titles["draco"] = "Decoding beside Draco; normals on both sides (-qn) or on neither (draco)"
    titles["memory"] = "Peak memory of a process (memory)"
}

/^# / {
    colon = index($0, ":")
    key[++keys] = substr($0, 3, colon - 3)
    value[keys] = substr($0, colon + 2)
    next
}
$0 == columns || NF != width { next }
{ add() }

function add(    i) {
    count++
    for (i = 1; i <= width; i++)
        cell[count, i] = $i
    if ($1 == "fit" && $2 ~ /^fitting 3 x 80 / && !(($3, $6) in kernel))
        kernel[$3, $6] = count
}

# GFLOP/s of the whole encoder, after its row of samples.
function whole_fit(at,    rate, flop, ratio, i) {
    rate = kernel[cell[at, 3], "samples/s"]
    flop = kernel[cell[at, 3], "GFLOP/s"]
    if (!rate || !flop)
        return
    ratio = cell[at, 4] / cell[rate, 4]
    count++
    for (i = 1; i <= width; i++)
        cell[count, i] = cell[at, i]
    cell[count, 4] = cell[count, 5] = sprintf("%.5g", ratio * cell[flop, 4])
    cell[count, 6] = "GFLOP/s"
    for (i = 8; i <= 9; i++)
        if (cell[flop, i] != "")
            cell[count, i] = sprintf("%.4g", ratio * cell[flop, i])
}

# How much two threads gain in the register loop, where there is nothing else to hold them back.
function add_gain(    i, loop) {
    for (i = 1; i <= count; i++)
        if (cell[i, 1] == "fit" && cell[i, 2] ~ /^register loop/)
            loop[cell[i, 3]] = cell[i, 4] # the last one is the fastest set
    if (!loop[1] || !loop[2])
        return
    key[++keys] = "two threads"
    value[keys] = sprintf("%.2f x one, in the register loop%s", loop[2] / loop[1], loop[2] < 1.8 * loop[1] ? \
        ": other programs run, or the two share a core; their rows and ratios mean little" : "")
}

function is_number(text) {
    return text ~ /^-?[0-9.]+([eE][-+]?[0-9]+)?$/
}

# 6 digits or so, and separators between thousands.
function pretty(x,    text, whole) {
    if (x == "")
        return ""
    if (x < 1000)
        return sprintf("%.4g", x)
    text = sprintf("%d", x + 0.5)
    whole = ""
    while (length(text) > 3) {
        whole = " " substr(text, length(text) - 2) whole
        text = substr(text, 1, length(text) - 3)
    }
    return text whole
}

function percent(x) {
    return x == "" ? "" : sprintf("%.0f %%", 100 * x)
}

function print_table(    i) {
    for (i = 1; i <= keys; i++)
        printf "%-24s %s\n", key[i], value[i]
    for (i = 1; i <= sections; i++)
        print_section(order[i])
}

function print_section(section,    i, any) {
    for (i = 1; i <= count; i++) {
        if (cell[i, 1] != section)
            continue
        if (!any++)
            print_heading(section)
        print_line(i, section)
    }
}

# The columns that a section has.
function line_of(section, measure, threads, best, median, cpu, unit, of_sgemm, of_fma, of_draco,    line) {
    line = sprintf("%-36s %7s %12s %12s %12s  %-11s", measure, threads, best, median, cpu, unit)
    if (section == "fit" || section == "encode")
        line = line sprintf(" %9s", of_sgemm)
    if (section == "fit" || section == "encode" || section == "decode")
        line = line sprintf(" %9s", of_fma)
    if (section == "draco")
        line = line sprintf(" %9s", of_draco)
    sub(/ +$/, "", line)
    return line
}

function print_heading(section) {
    printf "\n%s\n%s\n", titles[section],
        line_of(section, "", "threads", "best", "median", "cpu", "", "of sgemm", "of loop", "NSDF / it")
}

function print_line(i, section) {
    print line_of(section, cell[i, 2], cell[i, 3], pretty(cell[i, 4]), cell[i, 7] > 1 ? pretty(cell[i, 5]) : "",
        pretty(cell[i, 11]), cell[i, 6], percent(cell[i, 8]), percent(cell[i, 9]), cell[i, 10] == "" ? "" : sprintf("%.2f x", cell[i, 10]))
}

function print_csv(    i, j) {
    print columns
    for (i = 1; i <= count; i++)
        for (j = 1; j <= width; j++)
            printf "%s%s", cell[i, j], j < width ? "," : "\n"
}

function quoted(text) {
    gsub(/[\\"]/, "\\\\&", text)
    return "\"" text "\""
}

function print_json(    i, j, line) {
    print "{"
    for (i = 1; i <= keys; i++)
        printf "  %s: %s,\n", quoted(key[i]), quoted(value[i])
    print "  \"rows\": ["
    for (i = 1; i <= count; i++) {
        line = ""
        for (j = 1; j <= width; j++)
            if (cell[i, j] != "")
                line = line (line == "" ? "" : ", ") quoted(column[j]) ": " \
                    (is_number(cell[i, j]) ? cell[i, j] : quoted(cell[i, j]))
        printf "    {%s}%s\n", line, i < count ? "," : ""
    }
    print "  ]\n}"
}

END {
    add_gain()
    rows = count
    for (i = 1; i <= rows; i++)
        if (cell[i, 1] == "encode" && cell[i, 6] == "samples/s")
            whole_fit(i)
    if (format == "json")
        print_json()
    else if (format == "csv")
        print_csv()
    else
        print_table()
}
