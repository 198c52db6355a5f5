# A server with a certificate that nobody has heard of is refused, and trusted when the environment says so.
mkdir files && cp fixture/tiny.nsdf files/file.nsdf
serve_tls files
url=https://localhost:$port/file.nsdf
decode=(nsdf-dec -q --frames 1 --resolution 24 -o hash:)
fails 1 "its certificate is not trusted: self-signed certificate" "${decode[@]}" "$url"
"${decode[@]}" fixture/tiny.nsdf >local
CURL_CA_BUNDLE=ca.pem "${decode[@]}" "$url" >remote
same local remote
SSL_CERT_FILE=$PWD/ca.pem "${decode[@]}" "$url" >remote
same local remote
CURL_CA_BUNDLE=ca.pem nsdf-dec -v --info "$url" 2>&1 >/dev/null | grep -c 'bytes'
grep -c ' 206 ' access.log
# The name counts too, and the file of certificates has to be there.
CURL_CA_BUNDLE=ca.pem fails 1 "its certificate is not trusted" "${decode[@]}" "https://127.0.0.1:$port/file.nsdf"
CURL_CA_BUNDLE=none.pem fails 1 "cannot read the certificates" "${decode[@]}" "$url"
CURL_CA_BUNDLE=ca.pem fails 1 "there is no such file" "${decode[@]}" "https://localhost:$port/other.nsdf"
serve_tls_no_more
